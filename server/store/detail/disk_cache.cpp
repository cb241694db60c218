#include "server/store/detail/disk_cache.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <xxhash.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <system_error>

#include "common/base/atomic_file.hpp"
#include "common/base/open_file.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

// The folder is measured after writing 1/16 of the limit.
constexpr std::uint64_t kScansPerLimit = 16;
constexpr std::size_t kSumBytes = sizeof(std::uint64_t);  // The checksum, stored after the block.

struct CachedBlock {
  fs::file_time_type used;
  std::uint64_t bytes = 0;
  fs::path path;
};

// Blocks are named by their number.
bool is_block_name(const std::string& name) {
  return name.find_first_not_of("0123456789") == std::string::npos;
}

std::vector<CachedBlock> blocks_in(const CacheFolder& folder) {
  std::vector<CachedBlock> found;
  for (const fs::path& entry : folder.entries()) {
    std::error_code error;
    for (fs::directory_iterator at(entry, error), end; !error && at != end; at.increment(error)) {
      std::error_code gone;  // Another process may remove the file at any time.
      if (!is_block_name(at->path().filename().string()) || !at->is_regular_file(gone)) continue;
      const CachedBlock block{.used = at->last_write_time(gone),
                              .bytes = gone ? 0 : at->file_size(gone),
                              .path = at->path()};
      if (!gone) found.push_back(block);
    }
  }
  return found;
}

}  // namespace

DiskCache::DiskCache(const fs::path& folder, std::uint64_t max_bytes)
    : folder_(folder, "blocks"), max_bytes_(max_bytes) {
  evict();
}

fs::path DiskCache::path_of(const std::string& file, std::uint64_t block) const {
  return folder_.path_of(file) / std::to_string(block);
}

std::optional<std::vector<std::byte>> DiskCache::find(const std::string& file,
                                                      std::uint64_t block) const {
  const fs::path path = path_of(file, block);
  std::ifstream stream(path, std::ios::binary | std::ios::ate);
  const auto size = static_cast<std::streamoff>(stream.tellg());
  if (!stream || size < static_cast<std::streamoff>(kSumBytes)) return std::nullopt;
  std::vector<std::byte> bytes(static_cast<std::size_t>(size));
  stream.seekg(0);
  if (!stream.read(reinterpret_cast<char*>(bytes.data()), size)) return std::nullopt;
  std::uint64_t sum = 0;
  std::memcpy(&sum, bytes.data() + bytes.size() - kSumBytes, kSumBytes);
  bytes.resize(bytes.size() - kSumBytes);
  if (XXH3_64bits(bytes.data(), bytes.size()) != sum) return std::nullopt;
  // The modification time records the last use.
  ::utimensat(AT_FDCWD, path.c_str(), nullptr, 0);
  return bytes;
}

void DiskCache::put(const std::string& file, std::uint64_t block,
                    std::span<const std::byte> bytes) {
  try {
    const std::uint64_t sum = XXH3_64bits(bytes.data(), bytes.size());
    AtomicFile into(folder_.create(file) / std::to_string(block),
                    AtomicFile::TemporaryKind::kUnnamed, kCachedFileMode);
    into.write_at(0, bytes);
    into.write_at(bytes.size(), std::as_bytes(std::span(&sum, 1)));
    into.commit(Durability::kProcessEnd);
  } catch (const std::system_error&) {
    return;  // A full disk is no error for the service_client.
  }
  const std::lock_guard lock(mutex_);
  bytes_since_scan_ += bytes.size() + kSumBytes;
  if (bytes_since_scan_ < max_bytes_ / kScansPerLimit) return;
  bytes_since_scan_ = 0;
  evict();
}

void DiskCache::remove(const std::string& file, std::uint64_t block) {
  std::error_code ignored;
  fs::remove(path_of(file, block), ignored);
}

void DiskCache::evict() {
  // One process at a time; others skip the eviction.
  const OpenFile file(::open(folder_.path_of(".lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600));
  if (!file.lock(LOCK_EX | LOCK_NB)) return;
  std::vector<CachedBlock> blocks = blocks_in(folder_);
  std::uint64_t bytes = 0;
  for (const CachedBlock& block : blocks) bytes += block.bytes;
  // Frees enough to make the next measurement worthwhile.
  const std::uint64_t allowed = max_bytes_ - max_bytes_ / kScansPerLimit;
  if (bytes <= allowed) return;
  std::sort(blocks.begin(), blocks.end(),
            [](const CachedBlock& a, const CachedBlock& b) { return a.used < b.used; });
  for (const CachedBlock& block : blocks) {
    if (bytes <= allowed) break;
    std::error_code ignored;
    fs::remove(block.path, ignored);
    bytes -= block.bytes;
  }
}

}  // namespace multitetra
