// The surface in one octree cube during simplification, from which tiles are cut off as in
// cube_surface.hpp, but by the number of remaining triangles.
//
// Cubes are simplified bottom-up: what remains in a cube's children is joined and simplified
// further, so that only the borders of tiles stay as they were; fewer remaining triangles make
// fewer tiles. The result depends only on the leaves, thresholds and limits.
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
  std::vector<SimplifiedTile> tiles;  // Already cut off.
  SimplifiedPiece rest;               // Not yet in a tile.
};

struct SimplifiedTileLimits {
  // Maximum remaining triangles of a tile.
  std::size_t triangles = 64'000;
  // Maximum original vertices of a tile; limits the memory and time of one thread.
  std::size_t vertices_before = 6'000'000;
  // The exponent of a cube that contains the whole surface; nothing is joined beyond it.
  int root_exponent = std::numeric_limits<int>::max();
};

// Joins the surfaces in a cube's children with the one that lies in no single child (`own`), if
// there is one, and simplifies what is not cut off. `options` must be the same for all cubes. Calls
// `checkpoint` repeatedly; an exception from it aborts the work. `obstacles` are triangles that lie
// in no single cube of this size but extend into this one; they are used only with
// `options.is_intersection_free`.
[[nodiscard]] SimplifiedCube join_simplified(
    const OctreeCube& cube, std::vector<SimplifiedCube> children,
    std::optional<SimplifiedPiece> own, const SimplificationOptions& options,
    const SimplifiedTileLimits& limits = {}, const std::function<void()>& checkpoint = [] {},
    Obstacles obstacles = {});

// Returns all tiles, sorted by cube; the rest at the root becomes one.
[[nodiscard]] std::vector<SimplifiedTile> all_tiles(SimplifiedCube root);

}  // namespace multitetra
