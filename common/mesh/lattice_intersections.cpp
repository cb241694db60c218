#include "common/mesh/lattice_intersections.hpp"

#include <cstdint>
#include <vector>

#include "common/mesh/lattice_plane.hpp"
#include "common/mesh/triangle_grid.hpp"

namespace multitetra {

LatticeIntersections lattice_intersections(const LatticeMesh& mesh) {
  std::vector<LatticeTriangle> triangles;
  triangles.reserve(mesh.triangles.size());
  for (const auto& [p, q, r] : mesh.triangles) {
    triangles.push_back({mesh.vertices[p], mesh.vertices[q], mesh.vertices[r]});
  }
  TriangleGrid before(triangles.size(), mesh.resolution);
  std::vector<std::uint8_t> is_in_pair(triangles.size(), 0);
  LatticeIntersections found;
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const TriangleBox box = box_of(triangles[t]);
    const LatticePlane shape(triangles[t]);
    before.visit_near(box, [&](std::uint32_t other) {
      if (intersect(shape, LatticePlane(triangles[other]))) {
        ++found.pairs;
        is_in_pair[t] = is_in_pair[other] = 1;
      }
      return false;
    });
    before.insert(t, box);
  }
  for (const std::uint8_t is_in : is_in_pair) found.triangles += is_in;
  return found;
}

}  // namespace multitetra
