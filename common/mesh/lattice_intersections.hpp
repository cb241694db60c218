// Self-intersections of a mesh on the lattice.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "common/mesh/mesh.hpp"

namespace multitetra {

struct LatticeIntersections {
  // Pairs of triangles that intersect (lattice_plane.hpp).
  std::size_t pairs = 0;
  std::size_t triangles = 0;  // Triangles in such pairs.

  friend bool operator==(const LatticeIntersections&, const LatticeIntersections&) = default;
};

// Exact. Takes time like the number of triangles when these are of similar size.
[[nodiscard]] LatticeIntersections lattice_intersections(const LatticeMesh& mesh);

// For each triangle 1 if it intersects another one, else 0. Requires triangles with an area. Pairs
// that `are_apart` is true for are known not to intersect.
[[nodiscard]] std::vector<std::uint8_t> triangles_in_pairs(
    std::span<const LatticeTriangle> triangles,
    const std::function<bool(std::uint32_t, std::uint32_t)>& are_apart);

}  // namespace multitetra
