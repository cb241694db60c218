// Finds where a surface that was simplified without checks intersects itself: among the triangles
// that have changed, as those that stay are known not to intersect each other.
//
//   ChangedTriangles changed(before, obstacles);
//   const auto corners = changed.intersecting_corners(mesh);  // Empty: there are none.
//
// Most triangles near to others share a vertex with them. Where the triangles around that vertex
// are seen side by side from some direction nothing else has to be compared there.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mesh/mesh.hpp"
#include "server/core/simplification/detail/collapsing_mesh.hpp"
#include "server/core/simplification/detail/embedding.hpp"

namespace multitetra {

class ChangedTriangles {
 public:
  // `before` does not intersect itself, nor the obstacles. What is referred to must stay valid.
  ChangedTriangles(const LatticeMesh& before, Obstacles obstacles)
      : vertices_(before.vertices), obstacles_(obstacles), known_(before.triangles) {}

  // For each vertex 1 if it is a corner of a triangle of `mesh` that intersects another one, or of
  // one that intersects an obstacle; empty if there is no such triangle. `mesh` is what collapses
  // have made of `before`. Triangles that are as they were in the last call are not compared with
  // each other: requires that those found to intersect then are again as they are in `before`.
  [[nodiscard]] std::vector<std::uint8_t> intersecting_corners(const CollapsingMesh& mesh);

 private:
  [[nodiscard]] LatticeTriangle placed(const TriangleIndices& triangle) const {
    const auto& [p, q, r] = triangle;
    return {vertices_[p], vertices_[q], vertices_[r]};
  }

  std::span<const LatticePoint> vertices_;
  Obstacles obstacles_;
  // The triangles of the last call, and before it of the surface before; kNone: removed.
  std::vector<TriangleIndices> known_;
};

}  // namespace multitetra
