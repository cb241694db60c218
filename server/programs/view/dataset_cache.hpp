// Caches the datasets that `view` has prepared, so that a volume opens at once the next time.
//
//   DatasetCache cache(default_cache_folder(), std::uint64_t{20} << 30);
//   const std::filesystem::path folder = cache.entry("head-27ae1f0c66b0d915");
//   ... write datasets into it ...
//   cache.evict();
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "common/base/cache_folder.hpp"
#include "common/base/open_file.hpp"

namespace multitetra {

// Returns $XDG_CACHE_HOME/multitetra, else ~/.cache/multitetra; empty if neither variable has an
// absolute path.
[[nodiscard]] std::filesystem::path default_cache_folder();

// Entries are folders. Several processes may share a cache: open entries are locked (flock) and not
// evicted.
class DatasetCache {
 public:
  // `bytes` limits the total size. Throws CacheFolderError.
  DatasetCache(const std::filesystem::path& folder, std::uint64_t bytes);
  DatasetCache(const DatasetCache&) = delete;
  DatasetCache& operator=(const DatasetCache&) = delete;

  // Returns the folder of an entry, creating it if necessary. Marks it as used, and keeps it open
  // until destruction. Requires a key of cache_key(). Throws std::filesystem::filesystem_error or
  // std::system_error.
  std::filesystem::path entry(const std::string& key);

  // Removes the least recently used marked entries until the rest is within the limit. Keeps open
  // entries even if they exceed it.
  void evict();

 private:
  CacheFolder folder_;
  std::uint64_t bytes_;
  std::map<std::string, OpenFile> open_;  // The locked folder of each key.
};

}  // namespace multitetra
