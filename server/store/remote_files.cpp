#include "server/store/remote_files.hpp"

#include <xxhash.h>

#include <algorithm>
#include <cassert>
#include <cstring>
#include <exception>
#include <utility>

#include "common/base/hex_text.hpp"
#include "server/store/detail/disk_cache.hpp"
#include "server/store/detail/resolved_url.hpp"
#include "server/store/detail/store_client.hpp"

namespace multitetra {
namespace {

constexpr long kPreconditionFailed = 412;

std::string name_of_version(const std::string& address, const std::string& version) {
  const std::string both = address + "\n" + version;
  const XXH128_hash_t hash = XXH3_128bits(both.data(), both.size());
  return hex_text(hash.high64) + hex_text(hash.low64);
}

}  // namespace

struct RemoteFiles::OpenFile {
  explicit OpenFile(MemoryCache& memory) : owner(memory) {}

  std::string address;  // The argument of open().
  std::string url;
  std::shared_ptr<StoreClient> client;
  std::uint64_t size = 0;
  std::string etag;           // Empty if there is none.
  std::string last_modified;  // Empty if there is none.
  std::string version;
  std::string cache_name;
  MemoryCache::Owner owner;

  [[nodiscard]] std::uint64_t blocks() const { return (size + kBlockBytes - 1) / kBlockBytes; }
  [[nodiscard]] std::size_t bytes_of(std::uint64_t block) const {
    return static_cast<std::size_t>(
        std::min<std::uint64_t>(kBlockBytes, size - block * kBlockBytes));
  }
  // If-Match cannot compare weak ETags.
  [[nodiscard]] std::vector<std::string> conditions() const {
    if (!etag.empty() && !etag.starts_with("W/")) return {"If-Match: " + etag};
    if (!last_modified.empty()) return {"If-Unmodified-Since: " + last_modified};
    return {};
  }
  [[nodiscard]] bool is_version_of(const HttpAnswer& answer) const {
    return answer.total == size &&
           (etag.empty() ? answer.last_modified == last_modified : answer.etag == etag);
  }
};

RemoteFiles::RemoteFiles(const RemoteFilesOptions& options)
    : options_(options), memory_(options.memory_bytes) {
  options_.http.on_retry = [this, also = options.http.on_retry] {
    ++retries_;
    if (also) also();
  };
  if (!options_.folder.empty()) {
    disk_ = std::make_unique<DiskCache>(options_.folder, options_.folder_bytes);
  }
}

RemoteFiles::~RemoteFiles() {
  for (std::jthread& fetcher : fetchers_) fetcher.request_stop();
  has_jobs_.notify_all();
}

std::shared_ptr<StoreClient> RemoteFiles::client_for(const std::string& origin, bool is_s3) {
  const std::lock_guard lock(mutex_);
  std::shared_ptr<StoreClient>& client = clients_[origin];
  if (!client) client = std::make_shared<StoreClient>(is_s3, options_.http);
  return client;
}

std::vector<std::byte> RemoteFiles::fetch_beginning(const std::string& address, std::size_t bytes,
                                                    OpenFile& file) {
  const ResolvedUrl place = resolved_url(address);
  file.address = address;
  file.url = place.address();
  file.client = client_for(place.origin, place.is_s3);
  HttpAnswer answer = file.client->send(
      {.address = file.url, .range = StoreRange{.first = 0, .length = bytes}, .most = bytes});
  if (!answer.is_good()) {
    throw StoreError(address, "the server returned status " + std::to_string(answer.status),
                     "Check the address, the network and the credentials");
  }
  file.size = answer.total;
  file.etag = answer.etag;
  file.last_modified = answer.last_modified;
  if (file.size == 0 || (file.etag.empty() && file.last_modified.empty())) {
    throw StoreError(address,
                     file.size == 0 ? "the server does not send the length of the file"
                                    : "the server sends neither ETag nor Last-Modified, so a "
                                      "replaced file cannot be detected",
                     "Use a server that does, or a local copy");
  }
  file.version =
      (file.etag.empty() ? file.last_modified : file.etag) + " " + std::to_string(file.size);
  file.cache_name = name_of_version(address, file.version);
  const std::lock_guard lock(mutex_);
  ++counts_.requests;
  counts_.fetched_bytes += answer.bytes.size();
  return std::move(answer.bytes);
}

std::string RemoteFiles::version_of(const std::string& address) {
  OpenFile file(memory_);
  (void)fetch_beginning(address, 1, file);
  return file.version;
}

std::shared_ptr<const RemoteFile> RemoteFiles::open(const std::string& address) {
  auto file = std::make_shared<OpenFile>(memory_);
  const std::vector<std::byte> bytes =
      fetch_beginning(address, kOpeningBlocks * kBlockBytes, *file);
  std::uint64_t block = 0;
  for (auto begin = bytes.begin(); begin != bytes.end(); ++block) {
    const auto end = begin + static_cast<std::ptrdiff_t>(file->bytes_of(block));
    auto kept = std::make_shared<const std::vector<std::byte>>(begin, end);
    if (disk_) disk_->put(file->cache_name, block, *kept);
    memory_.put(file->owner.key(block), std::move(kept));
    begin = end;
  }
  {
    const std::lock_guard lock(mutex_);
    counts_.fetched += block;
  }
  return std::make_shared<const RemoteFile>(shared_from_this(), std::move(file));
}

// Returns blocks from memory, waits for those that other threads fetch, and fetches the others.
RemoteFiles::Blocks RemoteFiles::blocks(const OpenFilePtr& file, std::uint64_t first,
                                        std::size_t count) {
  Blocks found(count);
  std::vector<std::shared_future<CachedBytes>> pending_elsewhere(count);
  std::vector<std::promise<CachedBytes>> promises(count);
  std::vector<bool> fetched_here(count);
  {
    const std::lock_guard lock(mutex_);
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint64_t block = first + i;
      found[i] = memory_.find(file->owner.key(block));
      if (found[i]) {
        ++counts_.memory_hits;
        continue;
      }
      const auto [at, is_first] = pending_.try_emplace(file->owner.key(block));
      if (is_first) at->second = promises[i].get_future().share();
      fetched_here[i] = is_first;
      if (!is_first) pending_elsewhere[i] = at->second;
    }
  }
  std::exception_ptr failure;
  for (std::size_t begin = 0; begin < count; ++begin) {
    if (!fetched_here[begin]) continue;
    std::size_t end = begin;
    while (end < count && fetched_here[end]) ++end;
    const auto run = std::span(found).subspan(begin, end - begin);
    if (!failure) {
      try {
        fetch_run(*file, first + begin, run);
      } catch (...) {
        failure = std::current_exception();
      }
    }
    for (std::size_t i = begin; i < end; ++i) {
      if (found[i]) memory_.put(file->owner.key(first + i), found[i]);
    }
    const std::lock_guard lock(mutex_);
    for (std::size_t i = begin; i < end; ++i) {
      pending_.erase(file->owner.key(first + i));
      if (found[i]) {
        promises[i].set_value(found[i]);
      } else {
        promises[i].set_exception(failure);
      }
    }
    begin = end;
  }
  if (failure) std::rethrow_exception(failure);
  for (std::size_t i = 0; i < count; ++i) {
    if (!found[i]) found[i] = pending_elsewhere[i].get();
  }
  return found;
}

// Reads the blocks from disk if cached there; fetches each remaining run in one request.
void RemoteFiles::fetch_run(const OpenFile& file, std::uint64_t first,
                            std::span<CachedBytes> into) {
  if (disk_) {
    for (std::size_t i = 0; i < into.size(); ++i) {
      auto bytes = disk_->find(file.cache_name, first + i);
      if (!bytes || bytes->size() != file.bytes_of(first + i)) continue;
      into[i] = std::make_shared<const std::vector<std::byte>>(*std::move(bytes));
      const std::lock_guard lock(mutex_);
      ++counts_.disk_hits;
    }
  }
  for (std::size_t begin = 0; begin < into.size(); ++begin) {
    if (into[begin]) continue;
    std::size_t end = begin;
    std::size_t bytes = 0;
    while (end < into.size() && !into[end]) bytes += file.bytes_of(first + end++);
    {
      const std::lock_guard lock(mutex_);
      ++counts_.requests;
    }
    try {
      const HttpAnswer answer = file.client->send(
          {.address = file.url,
           .range = StoreRange{.first = (first + begin) * kBlockBytes, .length = bytes},
           .headers = file.conditions(),
           .most = bytes});
      if (answer.status == kPreconditionFailed ||
          (answer.is_good() && !file.is_version_of(answer))) {
        throw StoreError(file.address, "the file has been replaced since it was opened",
                         "Reopen it; a server does so on SIGHUP");
      }
      if (!answer.is_good() || answer.bytes.size() != bytes) {
        throw StoreError(file.address,
                         "the server returned status " + std::to_string(answer.status),
                         "Check the address, the network and the credentials");
      }
      const std::byte* from = answer.bytes.data();
      for (std::size_t i = begin; i < end; ++i) {
        const std::size_t size = file.bytes_of(first + i);
        into[i] = std::make_shared<const std::vector<std::byte>>(from, from + size);
        from += size;
        if (disk_) disk_->put(file.cache_name, first + i, *into[i]);
      }
    } catch (...) {
      const std::lock_guard lock(mutex_);
      ++counts_.failures;
      throw;
    }
    const std::lock_guard lock(mutex_);
    counts_.fetched += end - begin;
    counts_.fetched_bytes += bytes;
    begin = end;
  }
}

// Returns sorted block numbers without duplicates.
std::vector<std::uint64_t> RemoteFiles::missing_blocks(const OpenFile& file,
                                                       std::span<const FileRange> ranges) {
  std::vector<std::uint64_t> missing;
  const std::lock_guard lock(mutex_);
  for (const FileRange& range : ranges) {
    if (range.size == 0) continue;
    const std::uint64_t last = (range.offset + range.size - 1) / kBlockBytes;
    for (std::uint64_t block = range.offset / kBlockBytes; block <= last; ++block) {
      const bool is_known = (!missing.empty() && missing.back() == block) ||
                            memory_.find(file.owner.key(block)) ||
                            pending_.contains(file.owner.key(block));
      if (!is_known) missing.push_back(block);
    }
  }
  std::sort(missing.begin(), missing.end());
  missing.erase(std::unique(missing.begin(), missing.end()), missing.end());
  return missing;
}

void RemoteFiles::prefetch_ranges(const OpenFilePtr& file, std::span<const FileRange> ranges) {
  const std::vector<std::uint64_t> missing = missing_blocks(*file, ranges);
  const std::size_t most = options_.memory_bytes / 2 / kBlockBytes;
  const std::lock_guard lock(mutex_);
  std::size_t added = 0;
  for (std::size_t i = 0; i < missing.size() && added < most;) {
    std::size_t blocks = 1;
    while (i + blocks < missing.size() && blocks < kMaxBlocksPerPrefetch &&
           missing[i + blocks] == missing[i] + blocks) {
      ++blocks;
    }
    jobs_.push_back({file, missing[i], blocks});
    job_blocks_ += blocks;
    added += blocks;
    i += blocks;
  }
  // Drops the oldest requests that have not started; they may not be needed anymore.
  while (job_blocks_ > most + kMaxBlocksPerPrefetch) {
    job_blocks_ -= jobs_.front().blocks;
    jobs_.pop_front();
  }
  while (fetchers_.size() < std::min(options_.fetchers, jobs_.size())) {
    fetchers_.emplace_back([this](const std::stop_token& stop) { work(stop); });
  }
  has_jobs_.notify_all();
}

std::uint64_t RemoteFiles::missing_bytes(const OpenFile& file, std::span<const FileRange> ranges) {
  std::uint64_t bytes = 0;
  for (const std::uint64_t block : missing_blocks(file, ranges)) bytes += file.bytes_of(block);
  return bytes;
}

void RemoteFiles::invalidate(const OpenFile& file, const FileRange& range) {
  if (range.size == 0) return;
  for (std::uint64_t block = range.offset / kBlockBytes;
       block <= (range.offset + range.size - 1) / kBlockBytes; ++block) {
    memory_.remove(file.owner.key(block));
    if (disk_) disk_->remove(file.cache_name, block);
  }
}

void RemoteFiles::work(const std::stop_token& stop) {
  while (true) {
    std::unique_lock lock(mutex_);
    if (!has_jobs_.wait(lock, stop, [this] { return !jobs_.empty(); })) return;
    const Job job = std::move(jobs_.front());
    jobs_.pop_front();
    job_blocks_ -= job.blocks;
    lock.unlock();
    try {
      (void)blocks(job.file, job.first, job.blocks);
    } catch (const std::exception&) {  // NOLINT: the thread that needs the block reports the error.
    }
  }
}

RemoteFiles::Counts RemoteFiles::counts() const {
  const std::lock_guard lock(mutex_);
  Counts counts = counts_;
  const MemoryCache::Counts memory = memory_.counts();
  counts.evictions = memory.evictions;
  counts.memory_bytes = memory.bytes;
  counts.retries = retries_;
  return counts;
}

// ---- RemoteFile

std::uint64_t RemoteFile::size() const { return file_->size; }
const std::string& RemoteFile::version() const { return file_->version; }

void RemoteFile::read(std::uint64_t offset, std::span<std::byte> into) const {
  assert(offset <= size() && into.size() <= size() - offset);
  constexpr std::size_t kMaxBlocksAtOnce = 64;  // Blocks, which bounds memory.
  while (!into.empty()) {
    const std::uint64_t first = offset / RemoteFiles::kBlockBytes;
    const std::uint64_t last = (offset + into.size() - 1) / RemoteFiles::kBlockBytes;
    const auto count =
        static_cast<std::size_t>(std::min<std::uint64_t>(kMaxBlocksAtOnce, last - first + 1));
    for (const CachedBytes& block : files_->blocks(file_, first, count)) {
      const auto begin = static_cast<std::size_t>(offset % RemoteFiles::kBlockBytes);
      const std::size_t size = std::min(into.size(), block->size() - begin);
      std::memcpy(into.data(), block->data() + begin, size);
      into = into.subspan(size);
      offset += size;
    }
  }
}

void RemoteFile::prefetch(std::span<const FileRange> ranges) const {
  files_->prefetch_ranges(file_, ranges);
}

std::uint64_t RemoteFile::missing_bytes(std::span<const FileRange> ranges) const {
  return files_->missing_bytes(*file_, ranges);
}

void RemoteFile::invalidate(const FileRange& range) const { files_->invalidate(*file_, range); }

}  // namespace multitetra
