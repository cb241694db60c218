// An isosurface as tiles, ready to be encoded.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "common/wire/tile.hpp"
#include "server/core/surface/cube_surface.hpp"

namespace multitetra {

struct TiledMesh {
  // Tetrahedra of the model.
  std::uint64_t tetrahedra = 0;
  // Tetrahedra that the surface crosses.
  std::uint64_t active_tetrahedra = 0;
  std::vector<TileMesh> tiles;  // Sorted by cube; independent of the number of threads.
};

// Takes the tiles of a surface as they become complete, in any order. Called concurrently.
using TakeTile = std::function<void(TileMesh)>;

// Returns the Draco speed for a tile: simplified ones are worth more time. A mesh that
// simplification leaves unchanged keeps the digest, and so the bytes, of an unsimplified one.
[[nodiscard]] inline int encoding_speed(const TileMesh& tile) {
  return tile.simplification_bound > 0 ? kSimplifiedEncodingSpeed : kDefaultEncodingSpeed;
}

}  // namespace multitetra
