// A second field evaluated at the vertices of a surface, and how well linear interpolation between
// the vertices represents it.
#pragma once

#include <vector>

#include "common/mesh/mesh.hpp"
#include "server/core/spectrum/prepared_volume.hpp"

namespace multitetra {

struct VertexScalars {
  std::vector<double> values;  // Trilinear, one a vertex; NaN where there is no field.
  // The largest difference between the field and what is interpolated linearly between the corners
  // of a triangle, at the middles of all triangles and of all edges between two; where there is no
  // field at a corner or in the middle it does not count.
  double largest_deviation = 0;
};

// `grid_to_world` is that of the mesh, which need not be of this field's dataset. Values and
// deviations depend on places alone, so a vertex in two tiles has the same value in both. Throws
// what reading a brick throws.
[[nodiscard]] VertexScalars vertex_scalars(const PreparedVolume& field, const LatticeMesh& mesh,
                                           const Affine& grid_to_world);

}  // namespace multitetra
