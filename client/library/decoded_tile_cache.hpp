// A cache of received tiles for later steps and streams, with fixed limits.
//
//   DecodedTileCache tiles({.triangles = 10'000'000});
//   tiles.keep(digest, mesh);
//   open.cached_tile_digests = tiles.digests_to_name();
//
// A tile is identified by its content, so it serves whatever isovalue, dataset or connection it
// came for. Beyond a limit the tiles that were unused for longest go first. Used by one thread at a
// time.
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

  // Keeps the tile as the one used last. Others may have to go for it; it is not kept at all if it
  // is larger than the limit by itself. Of a tile that came without normals and with them the
  // latter stays: it serves both.
  void keep(const ContentDigest& digest, std::shared_ptr<const LatticeMesh> mesh);
  // A manifest names this tile: it is used now. Nothing happens when it is not kept.
  void use(const ContentDigest& digest);

  [[nodiscard]] HeldTiles tiles() const;
  // The tiles for OpenStream::cached_tile_digests, which the server does not send: only tiles with
  // normals for a request with normals. A request may name kMaxHeldDigests tiles: of more, those
  // with the most triangles are named, because they spare the most bytes.
  [[nodiscard]] std::vector<ContentDigest> digests_to_name(std::size_t most = kMaxHeldDigests,
                                                           bool with_normals = false) const;

  [[nodiscard]] std::size_t size() const { return tiles_.size(); }
  [[nodiscard]] std::uint64_t triangles() const { return tiles_.weight(); }

 private:
  using Tiles = LruMap<ContentDigest, std::shared_ptr<const LatticeMesh>>;

  std::uint64_t max_tiles_;
  Tiles tiles_;  // Their weights are their triangles.
};

}  // namespace multitetra
