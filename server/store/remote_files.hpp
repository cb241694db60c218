// Files behind addresses (http://, https://, s3://bucket/key), read by ranges.
//
//   const auto files = std::make_shared<RemoteFiles>(RemoteFilesOptions{});
//   const auto head = files->open("https://store.example/head.mtd");
//   head->prefetch(ranges);
//   head->read(offset, into);
//
// Guaranteed: all that is read of an open file is of the version that was there when it was opened.
// Requests carry If-Match with its ETag (If-Unmodified-Since where it has none), and answers are
// compared with it; a file that was replaced is a StoreError. A server that ignores ranges, or
// sends neither ETag nor Last-Modified, is refused at the opening.
//
// A file is fetched in blocks of 128 KiB. Blocks that follow each other are one request, and a
// block that several threads ask for is fetched once. Blocks are kept in the memory cache and,
// where there is one, in a folder of this machine.
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
  // The folder of the disk cache; empty: none.
  std::filesystem::path folder = {};
  std::uint64_t folder_bytes = std::uint64_t{16} << 30;
  std::size_t fetchers = 8;  // Threads that fetch what will be needed.
  HttpStoreOptions http = {};
};

struct FileRange {
  std::uint64_t offset = 0;
  std::uint64_t size = 0;
};

// Shared by all open files: connections, caches and the threads that fetch ahead. Safe to use from
// several threads at once.
class RemoteFiles : public std::enable_shared_from_this<RemoteFiles> {
 public:
  static constexpr std::size_t kBlockBytes = std::size_t{128} << 10;
  static constexpr std::size_t kOpeningBlocks = 3;  // Fetched with the opening, in one request.
  // The most blocks of one prefetch request.
  static constexpr std::size_t kMaxBlocksPerRequest = 8;

  // Throws std::filesystem::filesystem_error when the folder cannot be made.
  explicit RemoteFiles(const RemoteFilesOptions& options = {});
  ~RemoteFiles();
  RemoteFiles(const RemoteFiles&) = delete;
  RemoteFiles& operator=(const RemoteFiles&) = delete;

  // One request. Throws StoreError.
  [[nodiscard]] std::shared_ptr<const RemoteFile> open(const std::string& address);
  // RemoteFile::version() of the file that is there now. One small request. Throws StoreError.
  [[nodiscard]] std::string version_of(const std::string& address);

  // Also for what others make of the blocks.
  [[nodiscard]] MemoryCache& memory() { return memory_; }

  struct Counts {
    std::uint64_t memory_hits = 0;  // Blocks,
    std::uint64_t disk_hits = 0;
    std::uint64_t fetched = 0;  // from their stores.
    std::uint64_t fetched_bytes = 0;
    std::uint64_t requests = 0;  // For ranges, the opening ones included.
    // Repeated requests.
    std::uint64_t retries = 0;
    std::uint64_t failures = 0;   // Requests that failed for good.
    std::uint64_t evictions = 0;  // From memory: blocks, and what others keep there.
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

  // Asks for the first `bytes` bytes and fills `file` with what the answer says of it.
  [[nodiscard]] std::vector<std::byte> ask(const std::string& address, std::size_t bytes,
                                           OpenFile& file);
  [[nodiscard]] Blocks blocks(const OpenFilePtr& file, std::uint64_t first, std::size_t count);
  void fetch_run(const OpenFile& file, std::uint64_t first, std::span<CachedBytes> into);
  void prefetch_ranges(const OpenFilePtr& file, std::span<const FileRange> ranges);
  [[nodiscard]] std::uint64_t missing_bytes(const OpenFile& file,
                                            std::span<const FileRange> ranges);
  [[nodiscard]] std::vector<std::uint64_t> missing_blocks(const OpenFile& file,
                                                          std::span<const FileRange> ranges);
  void forget(const OpenFile& file, const FileRange& range);
  std::shared_ptr<StoreClient> client_for(const std::string& origin, bool is_s3);
  void work(const std::stop_token& stop);

  RemoteFilesOptions options_;
  MemoryCache memory_;
  std::unique_ptr<DiskCache> disk_;  // Null without a folder.
  std::atomic<std::uint64_t> retries_ = 0;

  mutable std::mutex mutex_;  // Guards what follows, but for the threads.
  std::map<std::string, std::shared_ptr<StoreClient>> clients_;
  std::map<MemoryCache::Key, std::shared_future<CachedBytes>> under_way_;
  Counts counts_;
  std::deque<Job> jobs_;
  std::size_t job_blocks_ = 0;
  std::condition_variable_any has_jobs_;
  std::vector<std::jthread> fetchers_;  // Last: they end before what they use.
};

// An open file. Safe to use from several threads at once.
class RemoteFile {
 public:
  RemoteFile(std::shared_ptr<RemoteFiles> files, std::shared_ptr<const RemoteFiles::OpenFile> file)
      : files_(std::move(files)), file_(std::move(file)) {}

  [[nodiscard]] const std::string& address() const;
  [[nodiscard]] std::uint64_t size() const;
  // Differs between versions of the file.
  [[nodiscard]] const std::string& version() const;

  // Requires offset + into.size() <= size(). Throws StoreError.
  void read(std::uint64_t offset, std::span<std::byte> into) const;

  // Begins to fetch what is not there of these ranges, in this order, as far as it fits into half
  // of the memory. Does not wait, and never fails.
  void prefetch(std::span<const FileRange> ranges) const;
  // The bytes of these ranges that are neither cached nor being fetched, in whole blocks.
  [[nodiscard]] std::uint64_t missing_bytes(std::span<const FileRange> ranges) const;
  // For bytes that turned out to be damaged: the next read fetches them again.
  void forget(const FileRange& range) const;

  [[nodiscard]] const std::shared_ptr<RemoteFiles>& files() const { return files_; }

 private:
  std::shared_ptr<RemoteFiles> files_;
  std::shared_ptr<const RemoteFiles::OpenFile> file_;
};

}  // namespace multitetra
