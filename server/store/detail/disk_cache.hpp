// Caches blocks of remote files in a local folder, for later starts and for other servers on this
// machine.
//
// Any number of processes may share a folder. A block appears complete or not at all; its checksum
// is verified when it is read. Above the limit, one process at a time evicts the least recently
// used blocks. A folder that cannot be read or written only costs speed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/base/cache_folder.hpp"

namespace multitetra {

// Safe to use from several threads at once.
class DiskCache {
 public:
  // Claims the folder for the blocks. Throws CacheFolderError; ignores later errors.
  DiskCache(const std::filesystem::path& folder, std::uint64_t max_bytes);

  // Finds a block of one version of a file. `file` names the version, as a valid file name.
  [[nodiscard]] std::optional<std::vector<std::byte>> find(const std::string& file,
                                                           std::uint64_t block) const;
  void put(const std::string& file, std::uint64_t block, std::span<const std::byte> bytes);
  void remove(const std::string& file, std::uint64_t block);

 private:
  [[nodiscard]] std::filesystem::path path_of(const std::string& file, std::uint64_t block) const;
  void evict();

  CacheFolder folder_;
  std::uint64_t max_bytes_;
  std::mutex mutex_;                    // Guards the following members.
  std::uint64_t bytes_since_scan_ = 0;  // Bytes written since the last measurement of the folder.
};

}  // namespace multitetra
