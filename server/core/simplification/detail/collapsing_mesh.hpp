// The connectivity of a triangle mesh during edge collapses, which must preserve topology.
//
// A *collapse* moves a vertex u along an edge onto its other end v: the two triangles at the edge
// vanish, and the others around u get v instead of u. Only vertices with a closed ring of triangles
// move, so borders stay unchanged.
//
//     w2-----w1              w2-----w1
//     | \   / |              |  \    |       u loses all triangles; w0 = v, w1, ... is its ring
//     |   u---v = w0         |    \--v
//     | /   \ |              |  /    |
//     w3-----w4              w3-----w4
//
// A collapse preserves the topology exactly if w1 and the last vertex of the ring are the only
// common neighbours of u and v, and the edge between these two is not opposite to both u and v (the
// link condition: T. Dey, H. Edelsbrunner, S. Guha, D. Nekhayev, "Topology preserving edge
// contraction", 1999).
//
// Corner c of the mesh is corner c % 4 of triangle c / 4, where c % 4 < 3. The corner across the
// edge opposite to a corner is its *opposite*.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "common/mesh/mesh.hpp"

namespace multitetra {

class CollapsingMesh {
 public:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  enum class VertexKind : std::uint8_t {
    kInner,      // In a closed ring of triangles.
    kBorder,     // At the border, in one open fan of triangles.
    kIrregular,  // In several fans or none, or at an edge of more than two triangles.
  };

  // Requires triangles with three different vertices each, numbered 0 .. vertex_count - 1.
  CollapsingMesh(std::span<const TriangleIndices> triangles, std::uint32_t vertex_count);

  [[nodiscard]] const TriangleIndices& triangle(std::uint32_t index) const {
    return triangles_[index].vertices;
  }
  [[nodiscard]] std::uint32_t triangle_count() const {
    return static_cast<std::uint32_t>(triangles_.size());
  }
  [[nodiscard]] bool is_removed(std::uint32_t triangle) const {
    return triangles_[triangle].is_removed;
  }
  [[nodiscard]] VertexKind kind(std::uint32_t vertex) const { return kinds_[vertex]; }
  [[nodiscard]] std::uint32_t vertex(std::uint32_t corner) const {
    return triangles_[corner / 4].vertices[corner % 4];
  }
  [[nodiscard]] std::uint32_t opposite(std::uint32_t corner) const {
    return triangles_[corner / 4].opposite[corner % 4];
  }

  [[nodiscard]] static std::uint32_t triangle_of(std::uint32_t corner) { return corner / 4; }
  [[nodiscard]] static std::uint32_t corner_of(std::uint32_t triangle, std::uint32_t i) {
    return 4 * triangle + i;
  }
  [[nodiscard]] static std::uint32_t next(std::uint32_t corner) {
    return corner % 4 == 2 ? corner - 2 : corner + 1;
  }
  [[nodiscard]] static std::uint32_t previous(std::uint32_t corner) {
    return corner % 4 == 0 ? corner + 2 : corner - 1;
  }

  // Returns the corners at an inner vertex u, in ring order: triangle i is u, w_i, w_(i+1).
  void ring(std::uint32_t inner, std::vector<std::uint32_t>& corners) const;

  // Returns whether collapsing u onto w_0 preserves the topology. `ring` are the corners at u.
  [[nodiscard]] bool keeps_topology(std::span<const std::uint32_t> ring);
  // Collapses u onto w_0. Requires keeps_topology(ring). Afterwards `ring` contains w_0's corners
  // in the changed triangles, except for its first and last, whose triangles are removed.
  void collapse(std::span<const std::uint32_t> ring);

 private:
  // Half a cache line.
  struct alignas(32) Triangle {
    TriangleIndices vertices;
    bool is_removed = false;
    std::array<std::uint32_t, 3> opposite = {kNone, kNone, kNone};
  };

  void find_opposites();
  void find_kinds();
  void link(std::uint32_t corner, std::uint32_t other);
  // Calls visit(w) for the neighbours of a vertex that is not irregular.
  template <typename Visit>
  void visit_neighbours(std::uint32_t vertex, const Visit& visit) const;

  std::vector<Triangle> triangles_;
  std::vector<std::uint32_t> corner_of_;  // One corner of each vertex.
  std::vector<VertexKind> kinds_;
  // By vertex: the value of mark_ when keeps_topology last visited it.
  std::vector<std::uint32_t> marks_;
  std::uint32_t mark_ = 0;
};

}  // namespace multitetra
