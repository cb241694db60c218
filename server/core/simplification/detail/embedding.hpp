// Keeps a surface that does not cut itself that way: refuses collapses that would make triangles
// meet anywhere but in the vertices and edges that they share.
//
// Only new triangles can meet others, and each collapse that is let through leaves a surface that
// does not cut itself: so none of them does.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mesh/lattice_plane.hpp"
#include "common/mesh/mesh.hpp"
#include "common/mesh/triangle_grid.hpp"
#include "server/core/simplification/detail/collapsing_mesh.hpp"

namespace multitetra {

// Triangles of the same surface that are no part of the mesh, and stay as they are.
using Obstacles = std::span<const LatticeTriangle>;

class Embedding {
 public:
  // What is referred to must stay valid.
  Embedding(const CollapsingMesh& mesh, std::span<const LatticePoint> vertices,
            Obstacles obstacles);

  // Whether u can collapse onto w_0 of its ring; `ring` are u's corners, and nothing is moved yet.
  [[nodiscard]] bool allows(std::span<const std::uint32_t> ring);
  // Takes note of the collapse that was allowed last, before the mesh does it.
  void keep(std::span<const std::uint32_t> ring);

 private:
  [[nodiscard]] const LatticePoint& vertex(std::uint32_t corner) const {
    return vertices_[mesh_.vertex(corner)];
  }
  [[nodiscard]] LatticeTriangle triangle(std::uint32_t index) const;

  const CollapsingMesh& mesh_;
  std::span<const LatticePoint> vertices_;
  Obstacles obstacles_;
  TriangleGrid grid_;  // Obstacles come after the mesh's triangles.
  // For one collapse: the new triangles and their boxes.
  std::vector<LatticePlane> fan_;
  std::vector<TriangleBox> boxes_;
};

}  // namespace multitetra
