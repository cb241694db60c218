// The surface of a uniform level of a prepared dataset as sample shells: samples go from their
// bricks straight into the codec, without a model, vertices or Draco.
//
// A tile is the surface in an octree cube of kShellCells cells of the level a side, or of half as
// many where it would have more than kMaxTileTriangles. Tiles decode alone, and a level of
// kSpectrumSpacing or more takes the coarse samples alone.
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "common/wire/tile.hpp"
#include "server/core/planning/shell_steps.hpp"
#include "server/core/spectrum/prepared_volume.hpp"

namespace multitetra {

inline constexpr int kShellCells = 64;

// The tiles that are not empty, sorted by cube, encoded on all threads and the same for any number
// of them. The digest of a tile is that of its payload. Requires has_shells(). Throws Cancelled
// soon after `stop` is triggered, and what reading the volume throws. `max_cells` is a power of two
// from 8 to kShellCells, `max_triangles` at least 12 * 8^3: smaller ones are for tests.
[[nodiscard]] std::vector<EncodedTile> extract_shells(
    const PreparedVolume& volume, const ShellLevel& level, const std::stop_token& stop = {},
    int max_cells = kShellCells, std::uint32_t max_triangles = kMaxTileTriangles);

}  // namespace multitetra
