#include "server/volume/formats/image_stack.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

TEST(ImageStack, DistinguishesPatternsFromNames) {
  for (const char* pattern : {"a*.tif", "a?.tif", "a%d.tif", "a%03d.tif"}) {
    EXPECT_TRUE(is_stack_pattern(pattern)) << pattern;
  }
  for (const char* name : {"a.tif", "100%.tif", "a%s.tif", "a%3.tif", ""}) {
    EXPECT_FALSE(is_stack_pattern(name)) << name;
  }
}

std::vector<std::string> names(const std::filesystem::path& path) {
  std::vector<std::string> result;
  for (const auto& file : stack_files(path)) result.push_back(file.filename().string());
  return result;
}

TEST(ImageStack, ListsImagesOfAFolderOrPatternInOrder) {
  const TemporaryFolder folder;
  for (const char* name : {"s010.tif", "s9.tif", "s002.TIFF", "t1.tif", "s1.txt", ".s1.tif"}) {
    folder.file(name, "");
  }
  using Names = std::vector<std::string>;
  EXPECT_EQ(names(folder.path()), (Names{"s002.TIFF", "s9.tif", "s010.tif", "t1.tif"}));
  EXPECT_EQ(names(folder.path() / "s*.tif"), (Names{"s9.tif", "s010.tif"}));
  EXPECT_EQ(names(folder.path() / "s%03d.tif"), (Names{"s010.tif"}));
  EXPECT_EQ(names(folder.path() / "?1.tif"), (Names{"t1.tif"}));
  EXPECT_EQ(names(folder.path() / "x*.tif"), Names{});
  EXPECT_EQ(names(folder.path() / "none" / "*.tif"), Names{});
  folder.file("s1.png", "");
  EXPECT_EQ(names(folder.path() / "s*"), (Names{"s002.TIFF", "s9.tif", "s010.tif"}));
  EXPECT_EQ(names(folder.path() / "s*.png"), (Names{"s1.png"}));
}

}  // namespace
}  // namespace multitetra
