// A triangle mesh in world coordinates, whatever made it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/base/vec3.hpp"
#include "common/mesh/mesh.hpp"
#include "common/mesh/surface_distance.hpp"

namespace multitetra {

struct TriangleMesh {
  std::vector<Vec3> vertices;  // Finite.
  std::vector<TriangleIndices> triangles;
  // The vertices are at multiples of 2^-lattice grid steps, according to the file. None: it names
  // no lattice.
  std::optional<int> lattice = std::nullopt;
  // Components with a shorter bounding-box diagonal were removed, in samples, according to the
  // file.
  double min_component = 0;
};

struct WeldedMesh {
  // Every vertex is used by a triangle and has its position alone, and every triangle has three
  // different vertices.
  TriangleMesh mesh;
  std::uint64_t degenerate_triangles = 0;  // Left out: two corners were at the same place.
};

// The corners of each triangle.
[[nodiscard]] std::vector<SurfaceTriangle> triangles_of(const TriangleMesh& mesh);

// Joins vertices at exactly the same place; formats such as STL have every corner on its own.
[[nodiscard]] WeldedMesh welded(const TriangleMesh& mesh);

}  // namespace multitetra
