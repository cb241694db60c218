// The isosurface inside one tetrahedron (marching tetrahedra), with vertices on the lattice.
//
// A corner is positive when its value is greater than the isovalue. One corner against three gives
// a triangle, two against two a quad, which is cut along its shorter diagonal: there is no
// ambiguous case, and what two neighbours see of their common face is the same. A tetrahedron with
// a void corner carries no surface.
#pragma once

#include <array>
#include <cstddef>

#include "common/mesh.hpp"
#include "server/core/grid.hpp"

namespace multitetra {

struct TetrahedronSurface {
  std::array<LatticeTriangle, 2> triangles;
  std::size_t count = 0;  // 0, 1 or 2
};

// The vertex on the edge from g to h, values on different sides of the isovalue c. The edge runs
// along an axis, a face diagonal or a cube diagonal, so it has L equal steps u, and the vertex sits
// at g + q delta u with q = round(t L / delta) clamped to [1, L / delta - 1]: exactly on the edge
// and never at its ends. The same for (g, h) and (h, g), bit for bit.
[[nodiscard]] LatticePoint lattice_vertex(GridPoint g, double value_g, GridPoint h, double value_h,
                                          double c, int resolution);

// Triangles face the low values. Values that are NaN are void.
[[nodiscard]] TetrahedronSurface marching_tetrahedron(const std::array<GridPoint, 4>& corners,
                                                      const std::array<float, 4>& values,
                                                      double isovalue, int resolution);

}  // namespace multitetra
