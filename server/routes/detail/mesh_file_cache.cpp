#include "server/routes/detail/mesh_file_cache.hpp"

#include <algorithm>
#include <limits>

namespace multitetra {
namespace {

constexpr double kMaxShareFraction = 0.25;  // Fraction of the unreserved disk space.
constexpr std::uint64_t kUnlimited = std::numeric_limits<std::uint64_t>::max();

std::uint64_t disk_of(std::uint64_t capacity) { return capacity == 0 ? kUnlimited : capacity; }

}  // namespace

MeshFileCache::MeshFileCache(std::uint64_t capacity)
    : capacity_(capacity),
      disk_(disk_of(capacity), kMaxShareFraction),
      kept_(capacity),
      kept_in_memory_(std::min(capacity, kMaxMemoryBytes)) {}

std::optional<StoredMesh> MeshFileCache::find(const std::string& key) {
  const std::lock_guard lock(mutex_);
  const StoredMesh* known = kept_in_memory_.find(key);
  if (known == nullptr) known = kept_.find(key);
  if (known == nullptr) return std::nullopt;
  return *known;
}

Result<ByteReservations::Reservation> MeshFileCache::reserve(const std::string& share,
                                                             std::uint64_t bytes) {
  constexpr double kRetryAfter = 10;
  if (bytes > disk_.max_per_share()) {
    return fail(ErrorCode::kLimitExceeded,
                "The file has " + std::to_string(bytes) + " bytes; this server stores at most " +
                    std::to_string(disk_.max_per_share()) +
                    " in one file; allow a larger error, or request it as a stream.");
  }
  const std::lock_guard lock(mutex_);
  for (;;) {
    auto reservation = disk_.take(share, bytes);
    if (reservation) return *std::move(reservation);
    if (!kept_.evict_oldest()) break;
  }
  return tl::unexpected(Error{.code = ErrorCode::kUnavailable,
                              .text = "The server has no disk space for another file while others "
                                      "are being sent; retry in 10 s.",
                              .retry_after = kRetryAfter});
}

void MeshFileCache::keep(const std::string& key, const StoredMesh& mesh) {
  const std::lock_guard lock(mutex_);
  if (std::holds_alternative<SharedFile>(mesh.body.whole)) {
    kept_.add(key, mesh, weight_of(mesh));
  } else {
    kept_in_memory_.add(key, mesh, mesh.body.length + mesh.fields.size() + key.size());
  }
}

// Each entry is an open file, and file descriptors are scarce: the minimum weight limits the cache
// to kMaxFiles files.
std::size_t MeshFileCache::weight_of(const StoredMesh& mesh) const {
  constexpr std::uint64_t kMaxFiles = 128;
  return std::max({mesh.body.length, capacity_ / kMaxFiles, std::uint64_t{1}});
}

}  // namespace multitetra
