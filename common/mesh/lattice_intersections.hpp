// Self-intersections of a mesh on the lattice.
#pragma once

#include <cstddef>

#include "common/mesh/mesh.hpp"

namespace multitetra {

struct LatticeIntersections {
  // Pairs of triangles that intersect (lattice_plane.hpp).
  std::size_t pairs = 0;
  std::size_t triangles = 0;  // Triangles in such pairs.

  friend bool operator==(const LatticeIntersections&, const LatticeIntersections&) = default;
};

// Exact. Takes linear time for triangles of similar size.
[[nodiscard]] LatticeIntersections lattice_intersections(const LatticeMesh& mesh);

}  // namespace multitetra
