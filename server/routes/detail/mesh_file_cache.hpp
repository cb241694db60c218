// Mesh files on disk: those that are being sent, and in the remaining space those that are cached.
// Small files are cached in memory.
//
//   auto reserved = files.reserve(share, bytes);  // Evicts the least recently used files for it.
//   if (reserved) files.keep(key, store(std::move(*reserved)));
//   if (auto mesh = files.find(key)) send(*mesh);
//
// Thread-safe. Returned objects may outlive the cache.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

#include "common/base/lru_map.hpp"
#include "server/operations/byte_reservations.hpp"
#include "server/routes/detail/mesh_file.hpp"

namespace multitetra {

class MeshFileCache {
 public:
  // Holds at most `capacity` bytes on disk; one share may have a quarter of the unreserved space. 0
  // caches nothing and does not limit the files being sent.
  explicit MeshFileCache(std::uint64_t capacity);

  [[nodiscard]] std::optional<StoredMesh> find(const std::string& key);
  // Reserves space for a new file. Returns kLimitExceeded if it exceeds the largest allowed file,
  // kUnavailable if files being sent leave too little space.
  [[nodiscard]] Result<ByteReservations::Reservation> reserve(const std::string& share,
                                                              std::uint64_t bytes);
  void keep(const std::string& key, const StoredMesh& mesh);

 private:
  static constexpr std::uint64_t kMaxMemoryBytes = std::uint64_t{64} << 20;

  // Returns the weight of a cached mesh on disk.
  [[nodiscard]] std::size_t weight_of(const StoredMesh& mesh) const;

  const std::uint64_t capacity_;
  ByteReservations disk_;
  std::mutex mutex_;  // Guards the members below.
  LruMap<std::string, StoredMesh> kept_;
  LruMap<std::string, StoredMesh> kept_in_memory_;
};

}  // namespace multitetra
