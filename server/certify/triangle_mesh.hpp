// A triangle mesh in world coordinates, whatever made it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/base/vec3.hpp"
#include "common/mesh/mesh.hpp"

namespace multitetra {

struct TriangleMesh {
  std::vector<Vec3> vertices;  // Finite.
  std::vector<TriangleIndices> triangles;
  // The vertices are at multiples of 2^-lattice grid steps, according to the file. None: it names
  // no lattice.
  std::optional<int> lattice = std::nullopt;
};

struct WeldedMesh {
  // Every vertex is used by a triangle and has its position alone, and every triangle has three
  // different vertices.
  TriangleMesh mesh;
  std::uint64_t degenerate_triangles = 0;  // Left out: two corners were at the same place.
};

// Joins vertices at exactly the same place; formats such as STL have every corner on its own.
[[nodiscard]] WeldedMesh welded(const TriangleMesh& mesh);

}  // namespace multitetra
