#include "server/programs/view/dataset_cache.hpp"

#include <fcntl.h>
#include <sys/file.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <system_error>
#include <utility>
#include <vector>

namespace multitetra {
namespace {

namespace fs = std::filesystem;

struct Entry {
  fs::path path;
  fs::file_time_type used;
  std::uint64_t bytes = 0;
};

std::uint64_t bytes_below(const fs::path& folder) {
  std::uint64_t bytes = 0;
  std::error_code gone;  // Other processes may remove files meanwhile.
  for (fs::recursive_directory_iterator at(folder, gone), end; !gone && at != end;
       at.increment(gone)) {
    std::error_code ignored;
    const std::uint64_t size = at->is_regular_file(ignored) ? at->file_size(ignored) : 0;
    if (!ignored) bytes += size;
  }
  return bytes;
}

// Returns whether a name ends like those of cache_key(): "-" and 16 digits.
bool is_key(const std::string& name) {
  constexpr std::size_t kDigits = 16;
  return name.size() > kDigits && name[name.size() - kDigits - 1] == '-' &&
         name.find_first_not_of("0123456789abcdef", name.size() - kDigits) == std::string::npos;
}

std::vector<Entry> entries_in(const CacheFolder& folder) {
  std::vector<Entry> entries;
  for (const fs::path& path : folder.entries()) {
    std::error_code gone;
    const fs::file_time_type used = fs::last_write_time(path, gone);
    if (!gone && is_key(path.filename().string()))
      entries.push_back({path, used, bytes_below(path)});
  }
  std::sort(entries.begin(), entries.end(),
            [](const Entry& a, const Entry& b) { return a.used < b.used; });
  return entries;
}

// Opens and locks a folder; closed if another process has a conflicting lock.
OpenFile locked(const fs::path& folder, int kind) {
  OpenFile opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  return opened.lock(kind) ? std::move(opened) : OpenFile();
}

fs::path absolute_path_in(const char* variable) {
  const char* const value = std::getenv(variable);
  return value != nullptr && fs::path(value).is_absolute() ? fs::path(value) : fs::path();
}

}  // namespace

fs::path default_cache_folder() {
  if (const fs::path cache = absolute_path_in("XDG_CACHE_HOME"); !cache.empty()) {
    return cache / "multitetra";
  }
  const fs::path home = absolute_path_in("HOME");
  return home.empty() ? home : home / ".cache" / "multitetra";
}

DatasetCache::DatasetCache(const fs::path& folder, std::uint64_t bytes)
    : folder_(folder, "datasets"), bytes_(bytes) {}

fs::path DatasetCache::entry(const std::string& key) {
  if (open_.contains(key)) return folder_.path_of(key);
  fs::path path = folder_.create(key);
  OpenFile folder = locked(path, LOCK_SH);
  if (!folder.is_open()) throw std::system_error(errno, std::generic_category(), path.string());
  open_.emplace(key, std::move(folder));
  path = folder_.create(key);  // May have been evicted before the lock.
  fs::last_write_time(path, fs::file_time_type::clock::now());
  return path;
}

void DatasetCache::evict() {
  const std::vector<Entry> entries = entries_in(folder_);
  std::uint64_t all = 0;
  for (const Entry& entry : entries) all += entry.bytes;
  for (const Entry& entry : entries) {
    if (all <= bytes_) return;
    const OpenFile folder = locked(entry.path, LOCK_EX | LOCK_NB);
    if (!folder.is_open()) continue;
    std::error_code ignored;
    fs::remove_all(entry.path, ignored);
    all -= entry.bytes;
  }
}

}  // namespace multitetra
