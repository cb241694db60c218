// Writes 3D Tiles 1.1.
//
// Every cell has its own tileset: its root tile has the cell's surface as content, and as children
// the tilesets of those octants that may contain a surface. So viewers load only the parts that
// they look at. Coordinates are in metres along the grid's axes from its origin. The transform of
// the first tileset's root rotates and translates them to world space. It has no scale, as viewers
// differ in whether this scales geometricError.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "server/tilesets/tileset.hpp"

namespace multitetra {

// Facts about a cell's surface that are known after extraction.
struct CellFacts {
  bool is_empty = false;
  std::uint32_t crossed_octants = 0;  // See StepBegin.
};

// Returns the length of a grid step along each axis, in metres. An unknown unit counts as metres.
[[nodiscard]] Vec3 grid_step_metres(const DatasetInfo& info);

// Returns the tileset's JSON. Cells are at `folder` + cell_name() + ".json" and ".glb", relative to
// it. A tile's geometricError is the error_bound() of its level in metres: the error while its
// children are not shown. The tileset must contain the cell.
[[nodiscard]] std::string tileset_json(const Tileset& tileset, const OctreeCube& cell,
                                       const CellFacts& facts, std::string_view folder);

}  // namespace multitetra
