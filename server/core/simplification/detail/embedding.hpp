// Keeps a surface that does not cut itself that way: refuses collapses that would make triangles
// meet anywhere but in the vertices and edges that they share.
//
// Only new triangles can meet others, and each collapse that is let through leaves a surface that
// does not cut itself: so none of them does.
//
// Most triangles near to new ones share a vertex with them. Where the triangles around that vertex
// are seen side by side from some direction nothing else has to be compared there.
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
  // One of the new triangles: of w_0 with two that follow each other in the ring.
  struct FanTriangle {
    LatticePlane plane;
    TriangleBox box;
    SeenTurns turns;
  };
  // A vertex of the ring. `seen` is the number of the collapse in which it was one.
  struct RingVertex {
    std::uint32_t seen = 0;
    std::uint32_t place = 0;
  };

  void set_up_fan(std::span<const std::uint32_t> ring);
  void find_clear_stars(std::span<const std::uint32_t> ring);
  [[nodiscard]] bool is_star_clear(std::span<const std::uint32_t> ring, std::uint32_t place);
  [[nodiscard]] SeenTurns turns_around(std::uint32_t place) const;
  [[nodiscard]] bool fan_meets_itself() const;
  [[nodiscard]] bool fan_meets(std::uint32_t triangle) const;
  // The fan's triangles, as bits, that need not be compared with one of the mesh.
  [[nodiscard]] std::uint64_t cleared(std::uint32_t triangle) const;
  [[nodiscard]] LatticeTriangle triangle(std::uint32_t index) const;

  const CollapsingMesh& mesh_;
  std::span<const LatticePoint> vertices_;
  Obstacles obstacles_;
  TriangleTree tree_;             // Obstacles come after the mesh's triangles.
  std::vector<SeenTurns> turns_;  // By triangle of the mesh.
  // For one collapse.
  std::uint32_t now_ = 0;
  std::vector<RingVertex> ring_vertices_;   // By vertex.
  std::vector<std::uint32_t> going_;        // By triangle: in which collapse it went or moved.
  std::vector<FanTriangle> fan_;            // At k - 1 that of w_k and w_(k+1).
  std::vector<std::uint64_t> clear_stars_;  // By place in the ring: the fan's triangles there, if
                                            // the star is seen side by side.
  std::vector<std::uint32_t> corners_;
  std::vector<LatticePoint> around_;
};

}  // namespace multitetra
