// Topological checks of a welded mesh, made by clients before they display it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "common/mesh/lattice.hpp"
#include "common/mesh/mesh.hpp"

namespace multitetra {

// The places where a surface may end: the faces of a box, or up to `inset` inside them.
struct DataBorder {
  LatticePoint low;  // The corners of the box, in lattice coordinates.
  LatticePoint high;
  // The distance in lattice steps within which a vertex counts as on a face. An edge is on the
  // border if both ends are this close to one face.
  std::int32_t inset = 0;
  // The data has void samples (masks), at any of which a surface may end.
  bool anywhere = false;

  [[nodiscard]] bool contains_edge(const LatticePoint& a, const LatticePoint& b) const;
};

struct MeshTopology {
  std::int64_t vertices = 0;
  std::int64_t edges = 0;
  std::int64_t triangles = 0;
  std::int64_t euler_characteristic = 0;  // vertices - edges + triangles
  std::int64_t components = 0;            // Connected by shared vertices.
  std::int64_t border_edges = 0;          // Edges of a single triangle, on the data's border.
  std::int64_t open_edges = 0;            // Edges of a single triangle, elsewhere: cracks.
  // Edges of more than two triangles, or of two with inconsistent orientation.
  std::int64_t nonmanifold_edges = 0;
  std::int64_t degenerate_triangles = 0;  // Triangles with two equal corners.

  // Returns whether there is no crack, fold or degenerate triangle. Required of every mesh that is
  // displayed.
  [[nodiscard]] bool is_sound() const {
    return open_edges == 0 && nonmanifold_edges == 0 && degenerate_triangles == 0;
  }

  friend bool operator==(const MeshTopology&, const MeshTopology&) = default;
};

// Assumes that every vertex is used by a triangle, as in the results of index_triangles() and
// weld(). Takes O(triangles) time and about 24 bytes per triangle.
[[nodiscard]] MeshTopology topology(const LatticeMesh& mesh, const DataBorder& border);
// Does the same for arbitrary coordinates. Calls `is_on_border` for edges of a single triangle.
[[nodiscard]] MeshTopology topology(
    std::size_t vertices, std::span<const TriangleIndices> triangles,
    const std::function<bool(std::uint32_t, std::uint32_t)>& is_on_border);

// Returns the number of vertices whose triangles form several fans that share only the vertex.
// Requires fewer than 2^32 / 3 triangles, each with three different vertices. Takes about 48 bytes
// per triangle.
[[nodiscard]] std::int64_t nonmanifold_vertices(std::size_t vertices,
                                                std::span<const TriangleIndices> triangles);

}  // namespace multitetra
