// Whether two triangles of a mesh have a point in common that they should not have. Exact.
#pragma once

#include <array>
#include <cstdint>

#include "common/base/vec3.hpp"

namespace multitetra {

struct MeshTriangle {
  std::array<std::uint32_t, 3> vertices;
  std::array<Vec3, 3> places;
};

// Whether its corners lie on a line.
[[nodiscard]] bool is_flat(const std::array<Vec3, 3>& places);

// Whether the triangles have a point in common that is neither a vertex nor on an edge that both of
// them have; a triangle that is there twice has. Requires that neither is flat, and that two
// vertices have the same place exactly where they are the same.
[[nodiscard]] bool intersect(const MeshTriangle& a, const MeshTriangle& b);

}  // namespace multitetra
