// Unit normals at the vertices of an isosurface, from the field instead of from the triangles:
// shading that shows no ridges, however coarse the triangles are.
//
// The normal is minus the gradient of the field: it points from high values to low, as triangles
// do. The gradient at a vertex is interpolated trilinearly from the eight points of the unit cell
// around it, where it is a central difference:
//
//        .   .                 o  corner of the cell
//    .   o---o   .             x  vertex
//        | x |                 .  what the differences at the corners reach
//    .   o---o   .
//        .   .
//
// Void values are no part of it: a difference with a void neighbour is one-sided, with two of them
// zero, and corners that are void are left out. What lies outside of the grid counts as void, what
// lies between the data and the grid's end is the value outside.
//
// A normal depends on the prepared volume, the position and the source alone. So a vertex that two
// tiles share has the same normal in both, to the bit: no seam shows in the shading.
#pragma once

#include <span>
#include <vector>

#include "common/mesh/mesh.hpp"
#include "server/core/spectrum/prepared_volume.hpp"

namespace multitetra {

// Which values the cells and differences are made of.
enum class NormalSource {
  kSamples,  // All samples: a cell is one grid step, and the bricks around it are read.
  // Those at multiples of kSpectrumSpacing, which is the side of a cell. No brick of samples is
  // read: for previews whose finest spacing is as coarse.
  kCoarseSamples,
};

// Where there is no direction, because the gradient is zero or all around is void.
inline constexpr UnitVector kNoDirection = {0, 0, 1};

// The normals of lattice points in the order given, in world coordinates: covectors are mapped by
// the inverse transpose of index_to_world, so they stand upright on the surface also where that
// map stretches, shears or mirrors. Requires points within the grid. Memory in proportion to the
// bricks in the points' bounding box; throws what reading a brick throws.
[[nodiscard]] std::vector<UnitVector> vertex_normals(const PreparedVolume& volume,
                                                     std::span<const LatticePoint> points,
                                                     int lattice_resolution, NormalSource source);

}  // namespace multitetra
