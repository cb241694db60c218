// The surface in one octree cube while it is simplified, and how tiles are cut off from it: as in
// cube_surface.hpp, but by what simplification leaves.
//
// Cubes are simplified bottom-up. What is left in the children of a cube is joined and simplified
// on, so that only the borders of tiles stay as they were; how many tiles there are depends on how
// many triangles are left. The result is a function of the leaves, thresholds and limits alone.
#pragma once

#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "common/mesh/octree_cube.hpp"
#include "server/core/simplification/simplification.hpp"
#include "server/core/surface/cube_surface.hpp"

namespace multitetra {

struct SimplifiedTile {
  OctreeCube cube;
  SimplifiedPiece piece;
};

struct SimplifiedCube {
  OctreeCube cube;
  std::vector<SimplifiedTile> tiles;  // Cut off.
  SimplifiedPiece rest;               // Not yet in a tile.
};

struct SimplifiedTileLimits {
  std::size_t triangles = 64'000;           // That are left in a tile,
  std::size_t vertices_before = 6'000'000;  // and that it had: memory and time of one thread.
  // For a cube with all of the surface: nothing is joined beyond it.
  int root_exponent = std::numeric_limits<int>::max();
};

// The surface in a cube from that in its children, and from what lies in no single one of them
// (`own`), if anything does. Simplifies what stays together; `options` are the same for all cubes.
// `checkpoint` is called now and then: what it throws ends the work. `obstacles` are triangles that
// lie in no single cube of this size, but reach into this one; they count where surfaces are to
// stay embedded.
[[nodiscard]] SimplifiedCube join_simplified(
    const OctreeCube& cube, std::vector<SimplifiedCube> children,
    std::optional<SimplifiedPiece> own, const SimplificationOptions& options,
    const SimplifiedTileLimits& limits = {}, const std::function<void()>& checkpoint = [] {},
    Obstacles obstacles = {});

// The whole as tiles, sorted by cube: what is left at the root becomes one.
[[nodiscard]] std::vector<SimplifiedTile> all_tiles(SimplifiedCube root);

}  // namespace multitetra
