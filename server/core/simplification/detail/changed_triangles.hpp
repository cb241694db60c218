// Finds self-intersections of a surface that was simplified without checks. Only changed triangles
// are tested, as the others are known not to intersect each other.
//
//   ChangedTriangles changed(before, obstacles);
//   const auto corners = changed.intersecting_corners(mesh);  // Empty: there are none.
//
// Most triangles near others share a vertex with them. If the triangles around that vertex do not
// overlap when seen from some direction, they need no further test.
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
  // `before` must intersect neither itself nor the obstacles. Arguments must remain valid.
  ChangedTriangles(const LatticeMesh& before, Obstacles obstacles)
      : vertices_(before.vertices), obstacles_(obstacles), known_(before.triangles) {}

  // Returns, for each vertex, 1 if it is a corner of a triangle of `mesh` that intersects another
  // triangle or an obstacle; empty if there are none. `mesh` must result from collapses of
  // `before`. Triangles unchanged since the last call are not tested against each other: those
  // found to intersect then must have been reset to their state in `before`.
  [[nodiscard]] std::vector<std::uint8_t> intersecting_corners(const CollapsingMesh& mesh);

 private:
  [[nodiscard]] LatticeTriangle placed(const TriangleIndices& triangle) const {
    const auto& [p, q, r] = triangle;
    return {vertices_[p], vertices_[q], vertices_[r]};
  }

  std::span<const LatticePoint> vertices_;
  Obstacles obstacles_;
  // The triangles of the last call, initially those of the surface before; kNone if removed.
  std::vector<TriangleIndices> known_;
};

}  // namespace multitetra
