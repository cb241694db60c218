// Which parts of a cube a surface can be in: what a tree of cells leaves out.
#pragma once

#include <cstdint>

#include "common/mesh/octree_cube.hpp"
#include "server/core/spectrum/prepared_volume.hpp"

namespace multitetra {

// Whether the closed cube, of an exponent of at least kSpectrumExponent, holds values on both sides
// of the isovalue, those outside of the data included. Void samples are on neither side.
[[nodiscard]] bool is_crossed(const PreparedVolume& volume, const OctreeCube& cube,
                              double isovalue);

// Bit i is set where the closed cube.child(i) holds values on both sides of the isovalue (see
// DESIGN, section 3): only there a model that is refined to cubes of that size has a surface,
// whatever its thresholds are, since each of its tetrahedra has its corners in one such cube. What
// is set for a cube is set for those around it. Costs a look at the ranges of the cells of eight in
// it; a cube so small that its children are smaller than those has all bits.
[[nodiscard]] std::uint32_t crossed_octants(const PreparedVolume& volume, const OctreeCube& cube,
                                            double isovalue);

}  // namespace multitetra
