// An isosurface as tiles, ready to be encoded.
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "common/wire/tile.hpp"
#include "server/core/surface/cube_surface.hpp"

namespace multitetra {

struct TiledSurface {
  // Tetrahedra of the model.
  std::uint64_t tetrahedra = 0;
  // Those that the surface crosses.
  std::uint64_t active_tetrahedra = 0;
  std::vector<TileMesh> tiles;  // Sorted by cube; the same for any number of threads.
};

// Draco's, for a tile: a simplified one is worth more time. A mesh that simplification leaves as it
// is has the digest, and so the bytes, of one without.
[[nodiscard]] inline int encoding_speed(const TileMesh& tile) {
  return tile.simplification_bound > 0 ? kSimplifiedEncodingSpeed : kDefaultEncodingSpeed;
}

// The tiles as Draco bytes, in the same order, encoded on all threads. Throws Cancelled soon after
// `stop` is triggered.
[[nodiscard]] std::vector<EncodedTile> encode_tiles(const TiledSurface& surface,
                                                    std::stop_token stop = {});

}  // namespace multitetra
