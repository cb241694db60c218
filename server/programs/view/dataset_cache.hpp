// The folder in which `view` keeps the datasets that it has prepared, so that the same volume is
// shown at once the next time.
//
//   DatasetCache cache(default_cache_folder(), std::uint64_t{20} << 30);
//   const std::filesystem::path folder = cache.entry("head-27ae1f0c66b0d915");
//   ... datasets are written into it ...
//   cache.evict();
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

namespace multitetra {

// $XDG_CACHE_HOME/multitetra, else ~/.cache/multitetra; empty where neither variable holds an
// absolute path.
[[nodiscard]] std::filesystem::path default_cache_folder();

// Entries are folders. Several processes may use one cache: an entry that any of them has open is
// locked (flock) and is not evicted.
class DatasetCache {
 public:
  // `bytes` bounds all entries together. Creates the folder, readable by its owner alone. Throws
  // std::filesystem::filesystem_error.
  DatasetCache(std::filesystem::path folder, std::uint64_t bytes);
  ~DatasetCache();
  DatasetCache(const DatasetCache&) = delete;
  DatasetCache& operator=(const DatasetCache&) = delete;

  // The folder of an entry, created if there is none; it is used now, and open while this lives.
  // Requires a file name. Throws std::filesystem::filesystem_error or std::system_error.
  std::filesystem::path entry(const std::string& key);

  // Removes the entries that were used longest ago until the others fit. Entries that are open
  // stay, even when they alone are too large.
  void evict();

 private:
  std::filesystem::path folder_;
  std::uint64_t bytes_;
  std::map<std::string, int> open_;  // Key -> descriptor of the locked folder.
};

}  // namespace multitetra
