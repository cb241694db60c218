// The files of meshes on the disk: those that are being sent, and in the space that they leave,
// those that are kept for the next request.
//
//   auto reserved = files.reserve(share, bytes);  // Evicts cached files for it, the oldest first.
//   if (reserved) files.keep(key, store(std::move(*reserved)));
//   if (auto mesh = files.find(key)) send(*mesh);
//
// Safe to use from several threads at once. What it hands out may outlive it.
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
  // Holds at most `capacity` bytes; one share may have a quarter of what the others leave.
  // 0: none are kept, and as many as are wanted are being sent.
  explicit MeshFileCache(std::uint64_t capacity);

  [[nodiscard]] std::optional<StoredMesh> find(const std::string& key);
  // For a file that is about to be written. kLimitExceeded when it is larger than one may be,
  // kUnavailable while files that are being sent leave no space for it.
  [[nodiscard]] Result<ByteReservations::Reservation> reserve(const std::string& share,
                                                              std::uint64_t bytes);
  void keep(const std::string& key, const StoredMesh& mesh);

 private:
  // The weight of a cached mesh.
  [[nodiscard]] std::size_t weight_of(const StoredMesh& mesh) const;

  const std::uint64_t capacity_;
  ByteReservations disk_;
  std::mutex mutex_;  // Guards kept_.
  LruMap<std::string, StoredMesh> kept_;
};

}  // namespace multitetra
