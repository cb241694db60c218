// The surface in one octree cube while it is compacted, and how tiles are cut off from it: as in
// cube_surface.hpp, but by what compaction leaves.
//
// Cubes are compacted bottom-up. What is left in the children of a cube is joined and compacted on,
// so that only the borders of tiles stay as they were; how many tiles there are depends on how many
// triangles are left. The result is a function of the leaves, thresholds and limits alone.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "common/octree_cube.hpp"
#include "server/core/compaction.hpp"
#include "server/core/cube_surface.hpp"

namespace multitetra {

struct CompactedCube {
  OctreeCube cube;
  std::vector<TileMesh> tiles;  // Cut off.
  CompactedPiece rest;          // Not yet in a tile.
};

struct CompactedTileLimits {
  std::size_t triangles = 64'000;           // That are left in a tile,
  std::size_t vertices_before = 1'000'000;  // and that it had: memory and time of one thread.
};

// The surface in a cube from that in its children, and from what lies in no single one of them, if
// anything does. Compacts what stays together; `options` are those of the cube. `checkpoint` is
// called now and then: what it throws ends the work.
[[nodiscard]] CompactedCube join_compacted(
    const OctreeCube& cube, std::vector<CompactedCube> children, std::optional<LatticeMesh> own,
    const CompactionOptions& options, const CompactedTileLimits& limits = {},
    const std::function<void()>& checkpoint = [] {});

// The whole as tiles, sorted by cube: what is left at the root becomes one.
[[nodiscard]] std::vector<TileMesh> finished_tiles(CompactedCube root);

}  // namespace multitetra
