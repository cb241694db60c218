// The parts of a cube that a surface can cross; the others are omitted from tilesets.
#pragma once

#include <cstdint>
#include <optional>

#include "common/mesh/octree_cube.hpp"
#include "server/core/spectrum/prepared_volume.hpp"

namespace multitetra {

// Returns whether the closed cube has values on both sides of the isovalue, including values
// outside the data. Void samples are on neither side. Requires an exponent of at least
// kSpectrumExponent.
[[nodiscard]] bool is_crossed(const PreparedVolume& volume, const OctreeCube& cube,
                              double isovalue);

// Cells of kSpectrumSpacing steps, from the first to the last along each axis.
struct CellSpan {
  GridPoint first;
  GridPoint last;
};
// Returns the least box around the cells in the cube for which is_crossed() holds; nullopt if
// nothing is crossed.
[[nodiscard]] std::optional<CellSpan> crossed_cells(const PreparedVolume& volume,
                                                    const OctreeCube& cube, double isovalue);

// Returns a mask whose bit i is set if the closed cube.child(i) has values on both sides of the
// isovalue. In a model refined to cubes of that size, each tetrahedron has its corners in one such
// cube, so only these children can contain the surface, for any thresholds. A bit that is set for a
// cube is also set for the cubes around it. Reads the ranges of the cube's cells; returns 0xFF if
// the children are smaller than a cell.
[[nodiscard]] std::uint32_t crossed_octants(const PreparedVolume& volume, const OctreeCube& cube,
                                            double isovalue);

}  // namespace multitetra
