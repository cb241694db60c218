// A tree of cells as tilesets of 3D Tiles 1.1.
//
// Every cell has a tileset of its own, whose root is the cell: its surface is the content, and its
// children lead to the tilesets of its octants, those where no surface can be left out. So a tree
// grows only where one looks. Coordinates of tiles and their contents are metres along the grid's
// axes from its origin; the transform of the first tileset's root turns and moves them to where the
// data lies, and scales nothing: whether it would scale a geometricError is read in two ways.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "server/tilesets/cell_tree.hpp"

namespace multitetra {

// Facts about a cell's surface that are known once it is extracted.
struct CellFacts {
  bool is_empty = false;
  std::uint32_t crossed_octants = 0;  // As in StepBegin.
};

// The length of a grid step in metres along each axis; a dataset whose unit of length is not
// known counts as being in metres.
[[nodiscard]] Vec3 grid_step_metres(const DatasetInfo& info);

// The file's text. Cells are at `folder` + cell_name() + ".json" and ".glb", seen from it. A tile's
// geometricError is the error_bound() of its level in metres: what is wrong as long as its children
// are not shown. Requires that the tree has the cell.
[[nodiscard]] std::string tileset_json(const CellTree& tree, const OctreeCube& cell,
                                       const CellFacts& facts, std::string_view folder);

}  // namespace multitetra
