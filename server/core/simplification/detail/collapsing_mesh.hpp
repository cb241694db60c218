// A triangle mesh whose vertices disappear one by one: the connectivity of a surface while it is
// simplified, and which collapses leave its topology as it is.
//
// A *collapse* moves a vertex u along an edge onto its other end v: the two triangles at the edge
// vanish, the others around u get v for u. Only vertices with a closed ring of triangles move, so
// borders stay as they are.
//
//     w2-----w1              w2-----w1
//     | \   / |              |  \    |       u keeps nothing; w0 = v, w1, ... is its ring
//     |   u---v = w0         |    \--v
//     | /   \ |              |  /    |
//     w3-----w4              w3-----w4
//
// A collapse keeps the surface's topology exactly when u and v have no neighbours in common but w1
// and the last of the ring, and these two with u are no triangle's opposite side of v (the link
// condition: T. Dey, H. Edelsbrunner, S. Guha, D. Nekhayev, "Topology preserving edge contraction",
// 1999).
//
// Corner c of the mesh is corner c % 4 of triangle c / 4; there is no fourth. Across the edge that
// lies opposite to a corner there is another corner, its *opposite*.
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
    kBorder,     // In one fan of triangles, at the border.
    kIrregular,  // In several, or in none, or at an edge of more than two triangles.
  };

  // Triangles of vertices 0 .. vertex_count - 1, each of three different ones.
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

  // The corners at an inner vertex u, in the order of its ring: triangle i is u, w_i, w_(i+1).
  void ring(std::uint32_t inner, std::vector<std::uint32_t>& corners) const;

  // Whether collapsing u onto w_0 keeps the topology. `ring` are the corners at u.
  [[nodiscard]] bool keeps_topology(std::span<const std::uint32_t> ring);
  // Collapses u onto w_0; requires keeps_topology. Afterwards `ring` are w_0's corners in the
  // triangles that stay, but for its first and last, whose triangles are removed.
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
  // By vertex: when keeps_topology visited it last.
  std::vector<std::uint32_t> marks_;
  std::uint32_t mark_ = 0;
};

}  // namespace multitetra
