#include "common/base/open_file.hpp"

#include <sys/file.h>
#include <sys/stat.h>

#include <array>
#include <cerrno>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

TEST(OpenFile, ReadsUpToTheEndAndReportsFilesThatEndTooEarly) {
  const TemporaryFolder folder;
  const OpenFile file(folder.file("numbers", "0123456789"));
  EXPECT_EQ(file.regular_size(), 10);
  std::array<std::byte, 4> bytes{};
  EXPECT_EQ(file.read_some(8, bytes), 2);
  EXPECT_TRUE(file.read(6, bytes));
  EXPECT_EQ(bytes[3], std::byte{'9'});
  EXPECT_FALSE(file.read(8, bytes));
  EXPECT_EQ(errno, EIO);
  EXPECT_EQ(file.content(100), "0123456789");
  EXPECT_EQ(file.content(3), "012");
}

TEST(OpenFile, OnlyRegularFilesHaveASizeAndPipesAreNotWaitedFor) {
  const TemporaryFolder folder;
  EXPECT_FALSE(OpenFile(folder.path() / "missing").is_open());
  EXPECT_EQ(OpenFile(folder.path()).regular_size(), std::nullopt);
  const std::string pipe = (folder.path() / "pipe").string();
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(OpenFile(pipe).regular_size(), std::nullopt);
}

TEST(OpenFile, LocksEndWithTheObject) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.file("lock", "");
  const OpenFile second(path);
  {
    OpenFile first(path);
    ASSERT_TRUE(first.lock(LOCK_EX | LOCK_NB));
    const OpenFile moved = std::move(first);
    EXPECT_FALSE(second.lock(LOCK_EX | LOCK_NB));
  }
  EXPECT_TRUE(second.lock(LOCK_EX | LOCK_NB));
}

}  // namespace
}  // namespace multitetra
