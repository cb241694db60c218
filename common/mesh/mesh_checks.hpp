// Topological checks of a welded mesh, which clients make before they show it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "common/mesh/lattice.hpp"
#include "common/mesh/mesh.hpp"

namespace multitetra {

// Where a surface may end: on the six faces of a box, or up to `inset` inside of it.
struct DataBorder {
  LatticePoint low;  // The box, in lattice coordinates.
  LatticePoint high;
  std::int32_t inset =
      0;  // Lattice steps; an edge is on the border when both ends are this near to one face.
  bool anywhere =
      false;  // The data has void samples of its own (masks): a surface may end at any of them.

  [[nodiscard]] bool contains_edge(const LatticePoint& a, const LatticePoint& b) const;
};

struct MeshTopology {
  std::int64_t vertices = 0;
  std::int64_t edges = 0;
  std::int64_t triangles = 0;
  std::int64_t euler_characteristic = 0;  // vertices - edges + triangles
  std::int64_t components = 0;            // Connected by shared vertices.
  std::int64_t border_edges = 0;          // Edges of one triangle, on the data's border.
  std::int64_t open_edges = 0;            // Edges of one triangle, elsewhere: cracks.
  std::int64_t nonmanifold_edges =
      0;  // Edges of more than two triangles, or of two that disagree on the outside.
  std::int64_t degenerate_triangles = 0;  // Two corners are the same vertex.

  // No crack, no fold, nothing degenerate: what every state that is shown must be.
  [[nodiscard]] bool is_sound() const {
    return open_edges == 0 && nonmanifold_edges == 0 && degenerate_triangles == 0;
  }

  friend bool operator==(const MeshTopology&, const MeshTopology&) = default;
};

// Every vertex is taken to be used by a triangle, as in the results of index_triangles and weld.
// Time O(triangles), memory about 24 bytes a triangle.
[[nodiscard]] MeshTopology topology(const LatticeMesh& mesh, const DataBorder& border);
// The same of a mesh with any coordinates; `is_on_border` is called for the ends of edges of one
// triangle.
[[nodiscard]] MeshTopology topology(
    std::size_t vertices, std::span<const TriangleIndices> triangles,
    const std::function<bool(std::uint32_t, std::uint32_t)>& is_on_border);

// Vertices whose triangles form several fans, which have nothing but the vertex in common. Requires
// triangles of three different vertices, less than 2^32 / 3. Memory about 48 bytes a triangle.
[[nodiscard]] std::int64_t nonmanifold_vertices(std::size_t vertices,
                                                std::span<const TriangleIndices> triangles);

}  // namespace multitetra
