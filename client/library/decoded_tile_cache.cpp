#include "client/library/decoded_tile_cache.hpp"

#include <algorithm>

namespace multitetra {
namespace {

bool is_as_large(const LatticeMesh& a, const LatticeMesh& b) {
  return a.triangles.size() == b.triangles.size() && a.vertices.size() == b.vertices.size();
}

}  // namespace

void DecodedTileCache::keep(const ContentDigest& digest, std::shared_ptr<const LatticeMesh> mesh) {
  if (const auto* const kept = tiles_.find(digest)) {
    const bool is_better =
        (*kept)->normals.empty() && !mesh->normals.empty() && is_as_large(**kept, *mesh);
    if (!is_better) return;
  }
  const std::size_t triangles = mesh->triangles.size();
  tiles_.add(digest, std::move(mesh), triangles);
  while (tiles_.size() > max_tiles_) tiles_.evict_oldest();
}

void DecodedTileCache::use(const ContentDigest& digest) { (void)tiles_.find(digest); }

CachedTiles DecodedTileCache::tiles() const {
  CachedTiles held;
  for (const Tiles::Entry& tile : tiles_.entries()) held.emplace(tile.key, tile.value);
  return held;
}

std::vector<ContentDigest> DecodedTileCache::digests_to_name(std::size_t max_digests,
                                                             bool with_normals) const {
  std::vector<const Tiles::Entry*> largest_first;
  largest_first.reserve(tiles_.size());
  for (const Tiles::Entry& tile : tiles_.entries()) {
    if (!with_normals || !tile.value->normals.empty()) largest_first.push_back(&tile);
  }
  std::sort(largest_first.begin(), largest_first.end(),
            [](const Tiles::Entry* a, const Tiles::Entry* b) {
              const auto size_a = a->value->triangles.size();
              const auto size_b = b->value->triangles.size();
              return size_a != size_b ? size_a > size_b : a->key < b->key;
            });
  std::vector<ContentDigest> digests;
  for (const Tiles::Entry* tile : largest_first) {
    if (digests.size() == max_digests) break;
    digests.push_back(tile->key);
  }
  return digests;
}

}  // namespace multitetra
