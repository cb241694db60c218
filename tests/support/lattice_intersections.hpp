// Self-intersections of a mesh on the lattice.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/mesh/lattice_plane.hpp"
#include "common/mesh/mesh.hpp"
#include "common/mesh/triangle_tree.hpp"

namespace multitetra {
struct LatticeIntersections {
  // Pairs of triangles that intersect (lattice_plane.hpp).
  std::size_t pairs = 0;
  std::size_t triangles = 0;  // Triangles in such pairs.

  friend bool operator==(const LatticeIntersections&, const LatticeIntersections&) = default;
};

// Exact. Takes linear time for triangles of similar size.
[[nodiscard]] inline LatticeIntersections lattice_intersections(const LatticeMesh& mesh) {
  std::vector<LatticeTriangle> triangles;
  triangles.reserve(mesh.triangles.size());
  for (const auto& [p, q, r] : mesh.triangles) {
    triangles.push_back({mesh.vertices[p], mesh.vertices[q], mesh.vertices[r]});
  }
  std::vector<std::uint8_t> is_in_pair(triangles.size(), 0);
  LatticeIntersections found;
  std::vector<LatticePlane> planes;
  std::vector<TriangleBox> boxes;
  for (const LatticeTriangle& triangle : triangles) {
    planes.emplace_back(triangle);
    boxes.push_back(box_of(triangle));
  }
  const TriangleTree tree(boxes);
  for (std::uint32_t one = 0; one < triangles.size(); ++one) {
    tree.visit_near(boxes[one], [&](std::uint32_t other) {
      if (other > one && intersect(planes[one], planes[other])) {
        ++found.pairs;
        is_in_pair[one] = is_in_pair[other] = 1;
      }
      return false;
    });
  }
  for (const std::uint8_t is_in : is_in_pair) found.triangles += is_in;
  return found;
}

}  // namespace multitetra
