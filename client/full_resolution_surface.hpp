// The isosurface of a volume at full resolution, straight from the definition: what a server's
// surfaces are measured against.
//
// It is written independently of the server. The framework's finest tetrahedra are, for each cube
// of side 2 whose centre d has odd grid coordinates: for each of its six face centres f, each of
// the four midpoints m of that face's edges and each end k of that edge, the tetrahedron (d, f, m,
// k). So a cube has 48, and all cubes together have 6 n^3. A sample is positive when it is greater
// than the isovalue. In a tetrahedron the field is linear and its isosurface a triangle or a plane
// quadrangle; a tetrahedron with a void corner has none. Vertices are exact crossings, not on the
// lattice.
#pragma once

#include <span>
#include <vector>

#include "common/mesh/surface_distance.hpp"
#include "common/request/dataset_info.hpp"

namespace multitetra {

// In world coordinates. `samples` are the dataset's, x fastest, NaN where there is no field;
// requires as many as its dims say. Margin and the value outside are those of `info`. Triangles of
// a crossing through a sample may be degenerate, and they face either side.
[[nodiscard]] std::vector<SurfaceTriangle> full_resolution_surface(const DatasetInfo& info,
                                                                   std::span<const float> samples,
                                                                   double isovalue);

}  // namespace multitetra
