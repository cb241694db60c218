#include "client/library/decoded_tile_cache.hpp"

#include <algorithm>

namespace multitetra {
namespace {

std::uint64_t bytes_of(const LatticeMesh& mesh) {
  return mesh.vertices.size() * sizeof(LatticePoint) +
         mesh.triangles.size() * sizeof(TriangleIndices);
}

bool is_as_large(const LatticeMesh& a, const LatticeMesh& b) {
  return a.triangles.size() == b.triangles.size() && a.vertices.size() == b.vertices.size();
}

}  // namespace

void DecodedTileCache::keep(const ContentDigest& digest, std::shared_ptr<const LatticeMesh> mesh) {
  if (const auto known = places_.find(digest); known != places_.end()) {
    use(digest);
    std::shared_ptr<const LatticeMesh>& kept = known->second->mesh;
    if (kept->normals.empty() && !mesh->normals.empty() && is_as_large(*kept, *mesh)) {
      kept = std::move(mesh);
    }
    return;
  }
  if (mesh->triangles.size() > limits_.triangles || limits_.tiles == 0) return;
  triangles_ += mesh->triangles.size();
  bytes_ += bytes_of(*mesh);
  by_use_.push_front({digest, std::move(mesh)});
  places_.emplace(digest, by_use_.begin());
  while (triangles_ > limits_.triangles || places_.size() > limits_.tiles) drop_last();
}

void DecodedTileCache::use(const ContentDigest& digest) {
  const auto found = places_.find(digest);
  if (found != places_.end()) by_use_.splice(by_use_.begin(), by_use_, found->second);
}

void DecodedTileCache::drop_last() {
  const Kept& last = by_use_.back();
  triangles_ -= last.mesh->triangles.size();
  bytes_ -= bytes_of(*last.mesh);
  places_.erase(last.digest);
  by_use_.pop_back();
}

HeldTiles DecodedTileCache::tiles() const {
  HeldTiles held;
  for (const Kept& kept : by_use_) held.emplace(kept.digest, kept.mesh);
  return held;
}

std::vector<ContentDigest> DecodedTileCache::digests_to_name(std::size_t most,
                                                             bool with_normals) const {
  std::vector<const Kept*> largest_first;
  largest_first.reserve(by_use_.size());
  for (const Kept& kept : by_use_) {
    if (!with_normals || !kept.mesh->normals.empty()) largest_first.push_back(&kept);
  }
  std::sort(largest_first.begin(), largest_first.end(), [](const Kept* a, const Kept* b) {
    const auto size_a = a->mesh->triangles.size();
    const auto size_b = b->mesh->triangles.size();
    return size_a != size_b ? size_a > size_b : a->digest < b->digest;
  });
  std::vector<ContentDigest> digests;
  for (const Kept* kept : largest_first) {
    if (digests.size() == most) break;
    digests.push_back(kept->digest);
  }
  return digests;
}

}  // namespace multitetra
