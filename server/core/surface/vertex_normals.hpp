// Unit normals at the vertices of an isosurface, from the field instead of the triangles: the
// shading shows no ridges, however coarse the triangles are.
//
// The normal is minus the gradient of the field: it points from high values to low, like triangles.
// The gradient at a vertex is interpolated trilinearly from central differences at the eight
// corners of the unit cell around it:
//
//        .   .                 o  corner of the cell
//    .   o---o   .             x  vertex
//        | x |                 .  samples for the differences at the corners
//    .   o---o   .
//        .   .
//
// Void values are ignored: a difference with one void neighbour is one-sided, with two it is zero,
// and void corners are omitted. Values outside the grid are void; those between the data and the
// grid's end are the value outside.
//
// A normal depends only on the prepared volume, the position and the source. So a vertex shared by
// two tiles has the same normal in both, to the bit, and the shading shows no seam.
#pragma once

#include <span>
#include <vector>

#include "common/mesh/mesh.hpp"
#include "server/core/spectrum/prepared_volume.hpp"

namespace multitetra {

// The values that cells and differences are based on.
enum class NormalSource {
  kSamples,  // All samples: a cell is one grid step, and the bricks around it are read.
  // Samples at multiples of kSpectrumSpacing, which is the side of a cell. Reads no bricks of
  // samples; for previews whose finest spacing is as coarse.
  kCoarseSamples,
};

// Returned where the gradient is zero or all surrounding values are void.
inline constexpr UnitVector kNoDirection = {0, 0, 1};

// Returns the normals of lattice points, in order and in world coordinates: covectors are mapped by
// the inverse transpose of index_to_world, so they are perpendicular to the surface even if that
// map stretches, shears or mirrors. Requires points within the grid. Uses memory in proportion to
// the bricks in the points' bounding box. Rethrows exceptions from reading bricks.
[[nodiscard]] std::vector<UnitVector> vertex_normals(const PreparedVolume& volume,
                                                     std::span<const LatticePoint> points,
                                                     int lattice_resolution, NormalSource source);

}  // namespace multitetra
