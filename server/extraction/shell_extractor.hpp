// The surface of a uniform level of a prepared dataset as sample shells: passes samples from their
// bricks directly to the codec, without a model, vertices or Draco.
//
// A tile is the surface in an octree cube of kShellCells cells of the level a side, or in its
// octants if it would have more than kMaxTileTriangles. Tiles decode independently. Levels of
// kSpectrumSpacing or more read only the coarse samples.
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "common/wire/tile.hpp"
#include "server/core/planning/shell_steps.hpp"
#include "server/core/spectrum/prepared_volume.hpp"

namespace multitetra {

inline constexpr int kShellCells = 64;

// Returns the nonempty tiles, sorted by cube and encoded on all threads; the result does not depend
// on their number. A tile's digest is that of its payload. Requires has_shells(), a power of two
// from 8 to kShellCells for `max_cells`, and at least 12 * 8^3 for `max_triangles`; smaller values
// are for tests. Throws Cancelled soon after `stop` is triggered, and rethrows exceptions from
// reading the volume.
[[nodiscard]] std::vector<EncodedTile> extract_shells(
    const PreparedVolume& volume, const ShellLevel& level, const std::stop_token& stop = {},
    int max_cells = kShellCells, std::uint32_t max_triangles = kMaxTileTriangles);

}  // namespace multitetra
