// Keeps a surface intersection-free: rejects collapses whose new triangles would intersect others
// outside their common vertices and edges.
//
// Only new triangles can intersect others, and every accepted collapse leaves an intersection-free
// surface; so, by induction, does the whole simplification.
//
// Most triangles near new ones share a vertex with them. If the triangles around that vertex do not
// overlap when seen from some direction, they need no further test.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mesh/lattice_plane.hpp"
#include "common/mesh/mesh.hpp"
#include "common/mesh/triangle_tree.hpp"
#include "server/core/simplification/detail/collapsing_mesh.hpp"
#include "server/core/simplification/detail/star_projection.hpp"

namespace multitetra {

// Triangles of the same surface that are not part of the mesh and do not change.
using Obstacles = std::span<const LatticeTriangle>;

class Embedding {
 public:
  // All arguments must remain valid.
  Embedding(const CollapsingMesh& mesh, std::span<const LatticePoint> vertices,
            Obstacles obstacles);

  // Returns whether u can collapse onto w_0; `ring` are u's corners before the collapse.
  [[nodiscard]] bool allows(std::span<const std::uint32_t> ring);
  // Records the collapse that was accepted last. Call before the mesh performs it.
  void commit(std::span<const std::uint32_t> ring);

 private:
  // A new triangle, of w_0 and two consecutive vertices of the ring.
  struct FanTriangle {
    LatticePlane plane;
    TriangleBox box;
    OrientationMask turns;
  };
  // A vertex of the ring. `last_collapse` is the number of the last collapse whose ring contains
  // it.
  struct RingVertex {
    std::uint32_t last_collapse = 0;
    std::uint32_t place = 0;
  };

  void set_up_fan(std::span<const std::uint32_t> ring);
  void find_disjoint_stars(std::span<const std::uint32_t> ring);
  [[nodiscard]] bool is_star_clear(std::span<const std::uint32_t> ring, std::uint32_t place);
  [[nodiscard]] OrientationMask turns_around(std::uint32_t place) const;
  [[nodiscard]] bool fan_meets_itself() const;
  [[nodiscard]] bool fan_meets(std::uint32_t triangle) const;
  // Returns a mask of the fan's triangles that need not be tested against a triangle of the mesh.
  [[nodiscard]] std::uint64_t cleared(std::uint32_t triangle) const;
  [[nodiscard]] LatticeTriangle triangle(std::uint32_t index) const;

  const CollapsingMesh& mesh_;
  std::span<const LatticePoint> vertices_;
  Obstacles obstacles_;
  TriangleTree tree_;                   // Obstacles follow the mesh's triangles.
  std::vector<OrientationMask> turns_;  // Indexed by triangle of the mesh.
  // State of one collapse.
  std::uint32_t collapse_number_ = 0;
  std::vector<RingVertex> ring_vertices_;  // By vertex.
  std::vector<std::uint32_t> removed_in_;  // By triangle: the collapse that removed or moved it.
  // Element k - 1 is the triangle of w_k and w_(k+1).
  std::vector<FanTriangle> fan_;
  // By position in the ring: mask of the fan's triangles in its star, or 0 if they may overlap.
  std::vector<std::uint64_t> disjoint_stars_;
  std::vector<std::uint32_t> corners_;
  std::vector<LatticePoint> around_;
};

}  // namespace multitetra
