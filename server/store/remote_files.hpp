// Remote files (http://, https://, s3://bucket/key), read by ranges.
//
//   const auto files = std::make_shared<RemoteFiles>(RemoteFilesOptions{});
//   const auto head = files->open("https://store.example/head.mtd");
//   head->prefetch(ranges);
//   head->read(offset, into);
//
// Guaranteed: all bytes read from an open file belong to the version that existed when it was
// opened. Requests carry If-Match with its ETag (If-Unmodified-Since if it has none), and responses
// are compared with it; a replaced file throws StoreError. open() refuses servers that ignore
// ranges or send neither ETag nor Last-Modified.
//
// Files are fetched in blocks of 128 KiB. One request fetches consecutive blocks, and a block that
// several threads need is fetched once. They are cached in memory and optionally in a local folder.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "server/store/http_options.hpp"
#include "server/store/memory_cache.hpp"
#include "server/store/store_error.hpp"

namespace multitetra {

class DiskCache;
class StoreClient;
class RemoteFile;

struct RemoteFilesOptions {
  std::size_t memory_bytes = std::size_t{512} << 20;
  // Folder of the disk cache; empty for none.
  std::filesystem::path folder = {};
  std::uint64_t folder_bytes = std::uint64_t{16} << 30;
  std::size_t fetchers = 8;  // Number of prefetch threads.
  HttpStoreOptions http = {};
};

struct FileRange {
  std::uint64_t offset = 0;
  std::uint64_t size = 0;
};

// Connections, caches and prefetch threads that all open files share. Safe to use from several
// threads at once.
class RemoteFiles : public std::enable_shared_from_this<RemoteFiles> {
 public:
  static constexpr std::size_t kBlockBytes = std::size_t{128} << 10;
  static constexpr std::size_t kOpeningBlocks = 3;  // Fetched by the request that opens a file.
  // Maximum number of blocks per prefetch request.
  static constexpr std::size_t kMaxBlocksPerPrefetch = 8;

  // Throws std::filesystem::filesystem_error if the folder cannot be created.
  explicit RemoteFiles(const RemoteFilesOptions& options = {});
  ~RemoteFiles();
  RemoteFiles(const RemoteFiles&) = delete;
  RemoteFiles& operator=(const RemoteFiles&) = delete;

  // Sends one request. Throws StoreError.
  [[nodiscard]] std::shared_ptr<const RemoteFile> open(const std::string& address);
  // Returns the RemoteFile::version() that is currently at the address. Sends one small request.
  // Throws StoreError.
  [[nodiscard]] std::string version_of(const std::string& address);

  // Returns the cache, which also holds data that callers derive from blocks, such as unpacked
  // bricks.
  [[nodiscard]] MemoryCache& memory() { return memory_; }

  struct Counts {
    std::uint64_t memory_hits = 0;  // Blocks found in memory.
    std::uint64_t disk_hits = 0;
    std::uint64_t fetched = 0;  // Blocks fetched from stores.
    std::uint64_t fetched_bytes = 0;
    std::uint64_t requests = 0;  // Requests for ranges, including those that open files.
    // Retried requests.
    std::uint64_t retries = 0;
    std::uint64_t failures = 0;   // Requests that failed for good.
    std::uint64_t evictions = 0;  // From memory: blocks and other cached bytes.
    std::uint64_t memory_bytes = 0;
  };
  [[nodiscard]] Counts counts() const;

 private:
  friend class RemoteFile;
  struct OpenFile;
  struct Job {
    std::shared_ptr<const OpenFile> file;
    std::uint64_t first = 0;
    std::size_t blocks = 0;
  };
  using Blocks = std::vector<CachedBytes>;
  using OpenFilePtr = std::shared_ptr<const OpenFile>;

  // Requests the first `bytes` bytes and sets the members of `file` from the response.
  [[nodiscard]] std::vector<std::byte> fetch_beginning(const std::string& address,
                                                       std::size_t bytes, OpenFile& file);
  [[nodiscard]] Blocks blocks(const OpenFilePtr& file, std::uint64_t first, std::size_t count);
  void fetch_run(const OpenFile& file, std::uint64_t first, std::span<CachedBytes> into);
  void prefetch_ranges(const OpenFilePtr& file, std::span<const FileRange> ranges);
  [[nodiscard]] std::uint64_t missing_bytes(const OpenFile& file,
                                            std::span<const FileRange> ranges);
  [[nodiscard]] std::vector<std::uint64_t> missing_blocks(const OpenFile& file,
                                                          std::span<const FileRange> ranges);
  void invalidate(const OpenFile& file, const FileRange& range);
  std::shared_ptr<StoreClient> client_for(const std::string& origin, bool is_s3);
  void work(const std::stop_token& stop);

  RemoteFilesOptions options_;
  MemoryCache memory_;
  std::unique_ptr<DiskCache> disk_;  // Null without a folder.
  std::atomic<std::uint64_t> retries_ = 0;

  mutable std::mutex mutex_;  // Guards the following members, except the threads.
  std::map<std::string, std::shared_ptr<StoreClient>> clients_;
  std::map<MemoryCache::Key, std::shared_future<CachedBytes>> pending_;
  Counts counts_;
  std::deque<Job> jobs_;
  std::size_t job_blocks_ = 0;
  std::condition_variable_any has_jobs_;
  std::vector<std::jthread> fetchers_;  // Last, so that they end before what they use.
};

// An open file. Safe to use from several threads at once.
class RemoteFile {
 public:
  RemoteFile(std::shared_ptr<RemoteFiles> files, std::shared_ptr<const RemoteFiles::OpenFile> file)
      : files_(std::move(files)), file_(std::move(file)) {}

  [[nodiscard]] std::uint64_t size() const;
  // Identifies the version of the file.
  [[nodiscard]] const std::string& version() const;

  // Requires offset + into.size() <= size(). Throws StoreError.
  void read(std::uint64_t offset, std::span<std::byte> into) const;

  // Starts fetching the missing blocks of these ranges, in this order, up to half of the memory.
  // Does not wait, and never fails.
  void prefetch(std::span<const FileRange> ranges) const;
  // Returns the bytes of these ranges that are neither cached nor being fetched, in whole blocks.
  [[nodiscard]] std::uint64_t missing_bytes(std::span<const FileRange> ranges) const;
  // Drops cached blocks of a range that turned out to be damaged; the next read fetches them again.
  void invalidate(const FileRange& range) const;

  [[nodiscard]] const std::shared_ptr<RemoteFiles>& files() const { return files_; }

 private:
  std::shared_ptr<RemoteFiles> files_;
  std::shared_ptr<const RemoteFiles::OpenFile> file_;
};

}  // namespace multitetra
