// Blocks of remote files, kept in a folder of this machine: for the next start, and for other
// servers here.
//
// Any number of processes may use one folder. A block appears in it whole or not at all, with a
// checksum that is verified when it is read; the least recently used ones are removed when all
// together have more than the limit, by one process at a time. A folder that cannot be read or
// written costs speed and nothing else.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace multitetra {

// Safe to use from several threads at once.
class DiskCache {
 public:
  // Makes the folder, readable by its owner alone. Throws std::filesystem::filesystem_error when
  // that is impossible; later errors are ignored.
  DiskCache(std::filesystem::path folder, std::uint64_t most_bytes);

  // A block of one version of a file. `file` names both, in letters that a file name may have.
  [[nodiscard]] std::optional<std::vector<std::byte>> find(const std::string& file,
                                                           std::uint64_t block) const;
  void put(const std::string& file, std::uint64_t block, std::span<const std::byte> bytes);
  void remove(const std::string& file, std::uint64_t block);

 private:
  [[nodiscard]] std::filesystem::path path_of(const std::string& file, std::uint64_t block) const;
  void evict();

  std::filesystem::path folder_;
  std::uint64_t most_bytes_;
  std::mutex mutex_;             // Guards what follows.
  std::uint64_t put_since_ = 0;  // Bytes since the folder was measured.
};

}  // namespace multitetra
