#include "server/core/surface/marching_tetrahedra.hpp"

#include "server/core/framework/field.hpp"

namespace multitetra {

TetrahedronSurface marching_tetrahedron(const std::array<GridPoint, 4>& corners,
                                        const std::array<float, 4>& values, double isovalue,
                                        int resolution) {
  unsigned signs = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    if (is_void(values[i])) return {};
    if (static_cast<double>(values[i]) > isovalue) signs |= 1U << i;
  }
  const bool is_negative = six_times_volume(corners[0], corners[1], corners[2], corners[3]) < 0;
  const MarchingCase& c = kMarchingCases[signs][is_negative ? 1 : 0];
  std::array<LatticePoint, 4> polygon{};
  for (std::size_t k = 0; k < c.corners; ++k) {
    const auto [i, j] = kTetrahedronEdges[c.edges[k]];
    polygon[k] = lattice_vertex(corners[i], static_cast<double>(values[i]), corners[j],
                                static_cast<double>(values[j]), isovalue, resolution);
  }
  const auto& [p, q, r, s] = polygon;
  if (c.corners < 4) return {.triangles = {LatticeTriangle{p, q, r}}, .count = c.corners / 3U};
  if (is_cut_along_first(p, q, r, s)) {
    return {.triangles = {LatticeTriangle{p, q, r}, LatticeTriangle{p, r, s}}, .count = 2};
  }
  return {.triangles = {LatticeTriangle{q, r, s}, LatticeTriangle{q, s, p}}, .count = 2};
}

}  // namespace multitetra
