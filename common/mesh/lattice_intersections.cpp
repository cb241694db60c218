#include "common/mesh/lattice_intersections.hpp"

#include <cstdint>
#include <span>
#include <vector>

#include "common/mesh/lattice_plane.hpp"
#include "common/mesh/triangle_tree.hpp"

namespace multitetra {

namespace {

template <typename Visit>
void visit_intersections(std::span<const LatticeTriangle> triangles, const Visit& visit) {
  std::vector<LatticePlane> planes;
  std::vector<TriangleBox> boxes;
  planes.reserve(triangles.size());
  boxes.reserve(triangles.size());
  for (const LatticeTriangle& triangle : triangles) {
    planes.emplace_back(triangle);
    boxes.push_back(box_of(triangle));
  }
  const TriangleTree tree(boxes);
  for (std::uint32_t part = 0; part < tree.part_count(); ++part) {
    tree.visit_pairs(part, [&](std::uint32_t one, std::uint32_t other) {
      if (intersect(planes[one], planes[other])) visit(one, other);
    });
  }
}

}  // namespace

LatticeIntersections lattice_intersections(const LatticeMesh& mesh) {
  std::vector<LatticeTriangle> triangles;
  triangles.reserve(mesh.triangles.size());
  for (const auto& [p, q, r] : mesh.triangles) {
    triangles.push_back({mesh.vertices[p], mesh.vertices[q], mesh.vertices[r]});
  }
  std::vector<std::uint8_t> is_in_pair(triangles.size(), 0);
  LatticeIntersections found;
  visit_intersections(triangles, [&](std::uint32_t one, std::uint32_t other) {
    ++found.pairs;
    is_in_pair[one] = is_in_pair[other] = 1;
  });
  for (const std::uint8_t is_in : is_in_pair) found.triangles += is_in;
  return found;
}

}  // namespace multitetra
