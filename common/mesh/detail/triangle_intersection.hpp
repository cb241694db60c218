// Exact intersection tests for triangles of a mesh.
#pragma once

#include <array>
#include <cstdint>

#include "common/base/vec3.hpp"

namespace multitetra {

struct MeshTriangle {
  std::array<std::uint32_t, 3> vertices;
  std::array<Vec3, 3> positions;
};

// Returns whether the corners are collinear.
[[nodiscard]] bool is_flat(const std::array<Vec3, 3>& positions);

// Returns whether the triangles share a point outside their common vertices and edges; duplicates
// do. Requires that neither is flat, and that vertices coincide only if they are the same.
[[nodiscard]] bool intersect(const MeshTriangle& a, const MeshTriangle& b);

}  // namespace multitetra
