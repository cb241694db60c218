#include "common/mesh/lattice_intersections.hpp"

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "common/mesh/lattice_plane.hpp"
#include "common/mesh/triangle_tree.hpp"

namespace multitetra {

namespace {

template <typename AreApart, typename Visit>
void visit_intersections(std::span<const LatticeTriangle> triangles, const AreApart& are_apart,
                         const Visit& visit) {
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
      if (!are_apart(one, other) && intersect(planes[one], planes[other])) visit(one, other);
    });
  }
}

}  // namespace

std::vector<std::uint8_t> triangles_in_pairs(
    std::span<const LatticeTriangle> triangles,
    const std::function<bool(std::uint32_t, std::uint32_t)>& are_apart) {
  std::vector<std::uint8_t> is_in_pair(triangles.size(), 0);
  visit_intersections(triangles, are_apart, [&](std::uint32_t one, std::uint32_t other) {
    is_in_pair[one] = is_in_pair[other] = 1;
  });
  return is_in_pair;
}

LatticeIntersections lattice_intersections(const LatticeMesh& mesh) {
  std::vector<LatticeTriangle> triangles;
  triangles.reserve(mesh.triangles.size());
  for (const auto& [p, q, r] : mesh.triangles) {
    triangles.push_back({mesh.vertices[p], mesh.vertices[q], mesh.vertices[r]});
  }
  std::vector<std::uint8_t> is_in_pair(triangles.size(), 0);
  LatticeIntersections found;
  const auto any_may_meet = [](std::uint32_t, std::uint32_t) { return false; };
  visit_intersections(triangles, any_may_meet, [&](std::uint32_t one, std::uint32_t other) {
    ++found.pairs;
    is_in_pair[one] = is_in_pair[other] = 1;
  });
  for (const std::uint8_t is_in : is_in_pair) found.triangles += is_in;
  return found;
}

}  // namespace multitetra
