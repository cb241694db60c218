// A second field at the vertices of a surface, and its error under linear interpolation.
#pragma once

#include <vector>

#include "common/mesh/mesh.hpp"
#include "server/core/spectrum/prepared_volume.hpp"

namespace multitetra {

struct VertexScalars {
  std::vector<double> values;  // Trilinear values, one per vertex; NaN where there is no field.
  // The largest deviation of linear interpolation from the field, at the centers of all triangles
  // and the midpoints of all edges between two; ignores those without a field there or at a corner.
  double largest_deviation = 0;
};

// Evaluates the field at the vertices of a mesh, which may be of another dataset; `grid_to_world`
// is that of the mesh. Values and deviations depend only on places, so a vertex in two tiles has
// the same value in both. Rethrows exceptions from reading a brick.
[[nodiscard]] VertexScalars vertex_scalars(const PreparedVolume& field, const LatticeMesh& mesh,
                                           const Affine& grid_to_world);

}  // namespace multitetra
