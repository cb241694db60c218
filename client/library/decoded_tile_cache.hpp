// A cache of received tiles for later steps and streams, with fixed limits.
//
//   DecodedTileCache tiles({.triangles = 10'000'000});
//   tiles.keep(digest, mesh);
//   open.cached_tile_digests = tiles.digests_to_name();
//
// A tile is identified by its content, so it can be reused for any isovalue, dataset or connection.
// Evicts the least recently used tiles beyond a limit. Not thread-safe.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "client/library/assembler.hpp"
#include "common/base/lru_map.hpp"

namespace multitetra {

struct TileMemoryLimits {
  std::uint64_t tiles = 65'536;
  std::uint64_t triangles = 20'000'000;  // About 18 bytes each.
};

class DecodedTileCache {
 public:
  explicit DecodedTileCache(TileMemoryLimits limits = {})
      : max_tiles_(limits.tiles), tiles_(limits.triangles) {}

  // Stores the tile as the most recently used and evicts others as needed. Tiles larger than the
  // limit are not stored. A tile with normals replaces the same one without: it serves both
  // requests.
  void keep(const ContentDigest& digest, std::shared_ptr<const LatticeMesh> mesh);
  // Marks the tile as used because a manifest names it; no effect if it is not cached.
  void use(const ContentDigest& digest);

  [[nodiscard]] CachedTiles tiles() const;
  // Returns the tiles for OpenStream::cached_tile_digests, which the server does not send; with
  // `with_normals`, only tiles with normals. If more than `max_digests` are cached, names those
  // with the most triangles, because they save the most bytes.
  [[nodiscard]] std::vector<ContentDigest> digests_to_name(
      std::size_t max_digests = kMaxHeldDigests, bool with_normals = false) const;

  [[nodiscard]] std::size_t size() const { return tiles_.size(); }
  [[nodiscard]] std::uint64_t triangles() const { return tiles_.weight(); }

 private:
  using Tiles = LruMap<ContentDigest, std::shared_ptr<const LatticeMesh>>;

  std::uint64_t max_tiles_;
  Tiles tiles_;  // Weighted by their triangles.
};

}  // namespace multitetra
