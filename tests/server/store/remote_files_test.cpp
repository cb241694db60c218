// A file over HTTP, read by ranges: gives the bytes of one version, or an error.
#include "server/store/remote_files.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/folder_server.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

constexpr std::size_t kBlock = RemoteFiles::kBlockBytes;
constexpr std::size_t kSize = 40 * kBlock + 1234;

class RemoteFilesTest : public ::testing::Test {
 protected:
  RemoteFilesTest() : server_(folder_.path()) { folder_.file("file", content(1)); }

  static std::string content(unsigned seed) {
    std::string text(kSize, '\0');
    for (std::size_t i = 0; i < text.size(); ++i) {
      text[i] = static_cast<char>((i * 2654435761u + seed) >> 11);
    }
    return text;
  }
  [[nodiscard]] std::string address(const std::string& lie = "") const {
    return server_.address() + lie + "/file";
  }
  static RemoteFilesOptions quick(std::size_t memory_bytes = std::size_t{64} << 20) {
    return {
        .memory_bytes = memory_bytes,
        .http = {
            .max_attempts = 3, .first_pause = milliseconds(1), .longest_pause = milliseconds(5)}};
  }
  static std::shared_ptr<RemoteFiles> files(const RemoteFilesOptions& options = quick()) {
    return std::make_shared<RemoteFiles>(options);
  }
  static std::string part(const RemoteFile& file, std::uint64_t offset, std::size_t size) {
    std::string text(size, '\0');
    file.read(offset, std::as_writable_bytes(std::span(text)));
    return text;
  }
  template <typename Action>
  static std::string failure(const Action& action) {
    try {
      (void)action();
    } catch (const StoreError& error) {
      return error.what();
    }
    return "none";
  }
  static void wait_for_fetches(const RemoteFiles& files, std::uint64_t blocks) {
    for (int i = 0; i < 2000 && files.counts().fetched < blocks; ++i) {
      std::this_thread::sleep_for(milliseconds(5));
    }
    EXPECT_EQ(files.counts().fetched, blocks);
  }

  const TemporaryFolder folder_;
  const FolderServer server_;
};

TEST_F(RemoteFilesTest, CachesRangesThatItReads) {
  const auto all = files();
  const auto file = all->open(address());
  const std::string text = content(1);
  EXPECT_EQ(file->size(), kSize);
  for (const auto& [offset, size] :
       std::vector<std::pair<std::size_t, std::size_t>>{{0, 10},
                                                        {kBlock - 5, 10},
                                                        {3 * kBlock, 5 * kBlock},
                                                        {kSize - 7, 7},
                                                        {kSize, 0},
                                                        {0, kSize}}) {
    EXPECT_TRUE(part(*file, offset, size) == text.substr(offset, size)) << offset;
  }
  EXPECT_EQ(all->counts().fetched, 41U) << "Each block once.";
  EXPECT_TRUE(part(*file, 5, kSize - 5) == text.substr(5));
  EXPECT_EQ(all->counts().fetched, 41U);
}

TEST_F(RemoteFilesTest, OpensAndReadsNeighboursWithOneRequestEach) {
  const auto all = files();
  const auto file = all->open(address());
  EXPECT_EQ(all->counts().requests, 1U);
  (void)part(*file, 0, RemoteFiles::kOpeningBlocks * kBlock);
  EXPECT_EQ(all->counts().requests, 1U);
  (void)part(*file, 10 * kBlock + 1, 4 * kBlock);
  EXPECT_EQ(all->counts().requests, 2U);
}

TEST_F(RemoteFilesTest, StaysWithinItsMemory) {
  const auto all = files(quick(16 * 3 * kBlock));
  const auto file = all->open(address());
  EXPECT_TRUE(part(*file, 0, kSize) == content(1));
  EXPECT_LE(all->counts().memory_bytes, 16 * 3 * kBlock);
  const auto none = files(quick(0));
  EXPECT_TRUE(part(*none->open(address()), 0, kSize) == content(1));
  EXPECT_EQ(none->counts().memory_bytes, 0U);
}

TEST_F(RemoteFilesTest, PrefetchesInFewRequestsWithoutWaiting) {
  const auto all = files();
  const auto file = all->open(address());
  const std::vector<FileRange> ranges = {
      {10 * kBlock + 3, 5 * kBlock}, {15 * kBlock + 9, 2 * kBlock}, {12 * kBlock, 100}};
  EXPECT_EQ(file->missing_bytes(ranges), 8 * kBlock);
  file->prefetch(ranges);
  wait_for_fetches(*all, RemoteFiles::kOpeningBlocks + 8);
  EXPECT_EQ(all->counts().requests, 2U);
  EXPECT_EQ(file->missing_bytes(ranges), 0U);
}

TEST_F(RemoteFilesTest, FetchesOnceForManyThreads) {
  const auto all = files();
  const auto file = all->open(address());
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 4; ++i) {
      threads.emplace_back([&] {
        const FileRange whole{0, kSize};
        file->prefetch({&whole, 1});
        EXPECT_TRUE(part(*file, 0, kSize) == content(1));
      });
    }
  }
  EXPECT_EQ(all->counts().fetched, 41U);
}

TEST_F(RemoteFilesTest, StopsDuringAPrefetch) {
  for (int i = 0; i < 10; ++i) {
    const auto all = files();
    const FileRange whole{0, kSize};
    all->open(address())->prefetch({&whole, 1});
  }
}

TEST_F(RemoteFilesTest, NeverMixesAFileWithItsReplacement) {
  for (const char* const server : {"", "/no-conditions", "/no-etag", "/weak-etag"}) {
    SCOPED_TRACE(server);
    folder_.file("file", content(1));
    const auto all = files();
    const auto file = all->open(address(server));
    const std::string version = file->version();
    EXPECT_EQ(all->version_of(address(server)), version);
    // Same size, other time: times in HTTP have a resolution of seconds.
    folder_.file("file", content(2));
    fs::last_write_time(folder_.path() / "file",
                        fs::file_time_type::clock::now() + std::chrono::seconds(5));
    EXPECT_NE(all->version_of(address(server)), version);
    EXPECT_TRUE(part(*file, 0, 100) == content(1).substr(0, 100)) << "What is there already.";
    EXPECT_NE(failure([&] { return part(*file, 20 * kBlock, 100); }).find("has been replaced"),
              std::string::npos);
    EXPECT_TRUE(part(*all->open(address(server)), 20 * kBlock, 100) ==
                content(2).substr(20 * kBlock, 100));
  }
}

TEST_F(RemoteFilesTest, RejectsServersThatCannotServeRanges) {
  const auto all = files();
  EXPECT_NE(failure([&] { return all->open(address("/whole")); }).find("does not serve ranges"),
            std::string::npos);
  EXPECT_NE(failure([&] {
              return all->open(address("/no-version"));
            }).find("neither ETag nor Last-Modified"),
            std::string::npos);
  EXPECT_NE(failure([&] { return all->open(server_.address() + "/none"); }).find("status 404"),
            std::string::npos);
  folder_.file("small", "x");
  EXPECT_NE(failure([&] {
              return all->open(server_.address() + "/whole/small");
            }).find("does not serve ranges"),
            std::string::npos);
}

TEST_F(RemoteFilesTest, RetriesTransientFailures) {
  for (const char* const lie : {"503", "truncated", "lost", "wrong-range", "long"}) {
    const auto all = files();
    const auto file = all->open(address(std::string("/lies/") + lie + "/2"));
    EXPECT_TRUE(part(*file, 0, kSize) == content(1)) << lie;
  }
}

TEST_F(RemoteFilesTest, ReportsPermanentFailures) {
  for (const char* const lie : {"503", "truncated", "lost", "wrong-range"}) {
    const auto all = files();
    const std::string text =
        failure([&] { return all->open(address(std::string("/lies/") + lie + "/1000")); });
    EXPECT_NE(text.find(server_.address()), std::string::npos) << lie << ": " << text;
  }
}

TEST_F(RemoteFilesTest, LimitsTheWaitForAStalledServer) {
  RemoteFilesOptions options = quick();
  options.http.deadline = milliseconds(400);
  const auto all = files(options);
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_NE(failure([&] { return all->open(address("/lies/stalled/1000")); }), "none");
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));
}

TEST_F(RemoteFilesTest, DiscardsDamagedBlocks) {
  const auto all = files();
  const auto file = all->open(address());
  (void)part(*file, 0, kSize);
  file->invalidate({5 * kBlock + 7, kBlock});
  EXPECT_EQ(file->missing_bytes(std::vector<FileRange>{{0, kSize}}), 2 * kBlock);
  EXPECT_TRUE(part(*file, 0, kSize) == content(1));
}

// ---- the disk cache

TEST_F(RemoteFilesTest, KeepsADiskCacheAcrossProcesses) {
  RemoteFilesOptions options = quick();
  options.folder = folder_.path() / "cache";
  for (int start = 0; start < 3; ++start) {
    const auto all = files(options);
    EXPECT_TRUE(part(*all->open(address()), 0, kSize) == content(1));
    EXPECT_EQ(all->counts().disk_hits, start == 0 ? 0U : 38U);
  }
  // Another version is another file.
  folder_.file("file", content(2));
  fs::last_write_time(folder_.path() / "file",
                      fs::file_time_type::clock::now() + std::chrono::seconds(5));
  EXPECT_TRUE(part(*files(options)->open(address()), 0, kSize) == content(2));
}

TEST_F(RemoteFilesTest, RefetchesWhenTheDiskCacheIsDamaged) {
  RemoteFilesOptions options = quick();
  options.folder = folder_.path() / "cache";
  EXPECT_TRUE(part(*files(options)->open(address()), 0, kSize) == content(1));
  std::size_t size = 0;
  for (const auto& entry : fs::recursive_directory_iterator(options.folder / "blocks")) {
    if (!entry.is_regular_file() || entry.path().filename() == "CACHEDIR.TAG") continue;
    std::ofstream(entry.path(), std::ios::binary | std::ios::trunc) << std::string(size, 'x');
    size = size * 7 + 1;
    if (size > 2 * kBlock) size = 0;
  }
  const auto all = files(options);
  EXPECT_TRUE(part(*all->open(address()), 0, kSize) == content(1));
  EXPECT_EQ(all->counts().disk_hits, 0U);
}

TEST_F(RemoteFilesTest, EvictsOnlyBlocksOfTheDiskCache) {
  RemoteFilesOptions options = quick(0);
  options.folder = folder_.path() / "cache";
  (void)files(options);
  folder_.file("cache/blocks/thesis/1", std::string(100 * kBlock, 'x'));
  folder_.file("cache/blocks/thesis.tex", "mine");
  options.folder_bytes = 8 * kBlock;
  const auto file = files(options)->open(address());
  for (std::size_t block = 0; block < 41; ++block) (void)part(*file, block * kBlock, 1);
  EXPECT_TRUE(fs::exists(options.folder / "blocks" / "thesis" / "1"));
  EXPECT_TRUE(fs::exists(options.folder / "blocks" / "thesis.tex"));
}

TEST_F(RemoteFilesTest, LimitsTheDiskCache) {
  RemoteFilesOptions options = quick(0);
  options.folder = folder_.path() / "cache";
  options.folder_bytes = 8 * kBlock;
  const auto file = files(options)->open(address());
  for (std::size_t block = 0; block < 41; ++block) {
    (void)part(*file, block * kBlock, 1);
    std::uint64_t bytes = 0;
    for (const auto& entry : fs::recursive_directory_iterator(options.folder)) {
      if (entry.is_regular_file()) bytes += entry.file_size();
    }
    EXPECT_LE(bytes, options.folder_bytes);
  }
}

}  // namespace
}  // namespace multitetra
