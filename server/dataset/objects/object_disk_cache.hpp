// Objects from far away, kept in a folder of this machine: for the next start, and for other
// servers here.
//
// Any number of processes may use one folder. An object appears in it whole or not at all; the
// least recently used ones are removed when all together have more than the limit, by one process
// at a time. What is found may be damaged: whoever takes it looks whether it is what its name says.
// A folder that cannot be read or written costs speed and nothing else.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "server/dataset/objects/object_name.hpp"

namespace multitetra {

// Safe to use from several threads at once.
class ObjectDiskCache {
 public:
  // Makes the folder, readable by its owner alone. Throws std::filesystem::filesystem_error when
  // that is impossible: the first trouble is told, later ones are not.
  ObjectDiskCache(std::filesystem::path folder, std::uint64_t most_bytes);

  [[nodiscard]] std::optional<std::vector<std::byte>> find(const ObjectName& name) const;
  void put(const ObjectName& name, std::span<const std::byte> bytes);
  void remove(const ObjectName& name);

 private:
  void make_room();

  std::filesystem::path folder_;
  std::uint64_t most_bytes_;
  std::mutex mutex_;             // Guards what follows.
  std::uint64_t put_since_ = 0;  // Bytes since the folder was measured.
};

}  // namespace multitetra
