#include "common/base/cache_folder.hpp"

#include <unistd.h>

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

std::string refusal(const fs::path& folder) {
  try {
    (void)CacheFolder(folder, "blocks");
    return "";
  } catch (const CacheFolderError& error) {
    return error.what();
  }
}

unsigned mode_of(const fs::path& path) {
  return static_cast<unsigned>(fs::status(path).permissions());
}

TEST(CacheFolder, IsPrivateAndMarked) {
  const TemporaryFolder temporary;
  const fs::path folder = temporary.path() / "new" / "cache";
  const fs::path entry = CacheFolder(folder, "blocks").create("a");
  for (const fs::path& place : {folder, folder / "blocks", entry}) {
    EXPECT_EQ(mode_of(place), 0700U) << place;
    EXPECT_EQ(mode_of(place / "CACHEDIR.TAG"), 0600U) << place;
  }
  EXPECT_TRUE(bytes_of_file(entry / "CACHEDIR.TAG")
                  .starts_with("Signature: 8a477f597d28d172789f06886806bc55\n"));
}

TEST(CacheFolder, IsUsedAgainAndByOtherKinds) {
  const TemporaryFolder temporary;
  (void)CacheFolder(temporary.path() / "cache", "blocks").create("a");
  EXPECT_EQ(CacheFolder(temporary.path() / "cache", "blocks").entries().size(), 1U);
  EXPECT_EQ(CacheFolder(temporary.path() / "cache/", "datasets").entries().size(), 0U);
}

TEST(CacheFolder, RefusesFoldersWithOtherFiles) {
  const TemporaryFolder temporary;
  temporary.file("thesis/thesis.tex", "mine");
  EXPECT_NE(refusal(temporary.path()).find("Give a new or empty folder."), std::string::npos);
  EXPECT_EQ(entries_of(temporary.path()), 1U);
  // Nor does the tag of another program open it.
  temporary.file("CACHEDIR.TAG", "Signature: 8a477f597d28d172789f06886806bc55\n# by cargo\n");
  EXPECT_NE(refusal(temporary.path()).find("Give a new or empty folder."), std::string::npos);
  // The same holds for the folder of a kind.
  temporary.file("cache/blocks/thesis.tex", "mine");
  fs::rename(temporary.path() / "cache" / "blocks", temporary.path() / "blocks");
  EXPECT_EQ(refusal(temporary.path() / "cache"), "");
  fs::remove_all(temporary.path() / "cache" / "blocks");
  fs::rename(temporary.path() / "blocks", temporary.path() / "cache" / "blocks");
  EXPECT_NE(refusal(temporary.path() / "cache").find("Give a new or empty folder."),
            std::string::npos);
}

TEST(CacheFolder, RefusesFoldersThatOthersCanChange) {
  const TemporaryFolder temporary;
  for (const fs::perms others : {fs::perms::group_write, fs::perms::others_write}) {
    const fs::path folder = temporary.path() / "shared";
    fs::create_directory(folder);
    fs::permissions(folder, others, fs::perm_options::add);
    EXPECT_NE(refusal(folder).find("other users may write into it"), std::string::npos);
    fs::permissions(folder, others, fs::perm_options::remove);
    EXPECT_EQ(refusal(folder), "");
    fs::permissions(folder / "blocks", others, fs::perm_options::add);
    EXPECT_NE(refusal(folder).find("other users may write into it"), std::string::npos);
    fs::remove_all(folder);
  }
  fs::create_directory(temporary.path() / "linked");
  (void)CacheFolder(temporary.path() / "cache", "datasets");
  fs::create_directory_symlink(temporary.path() / "linked", temporary.path() / "cache" / "blocks");
  EXPECT_NE(refusal(temporary.path() / "cache"), "");
}

TEST(CacheFolder, RefusesFoldersOfOtherUsers) {
  const TemporaryFolder temporary;
  const bool is_root = ::geteuid() == 0;
  if (is_root) {
    ASSERT_EQ(::chown(temporary.path().c_str(), 12345, 12345), 0);
  }
  EXPECT_NE(refusal(is_root ? temporary.path() : fs::path("/usr")).find("belongs to another user"),
            std::string::npos);
}

TEST(CacheFolder, ListsMarkedFoldersOnly) {
  const TemporaryFolder temporary;
  const CacheFolder cache(temporary.path() / "cache", "blocks");
  const fs::path entry = cache.create("a");
  temporary.file("cache/blocks/thesis/thesis.tex", "mine");
  temporary.file("cache/blocks/file", "mine");
  fs::create_directory_symlink(entry, temporary.path() / "cache" / "blocks" / "link");
  EXPECT_EQ(cache.entries(), std::vector{entry});
}

}  // namespace
}  // namespace multitetra
