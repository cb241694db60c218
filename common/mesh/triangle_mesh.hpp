// A triangle mesh in world coordinates, from any program.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/vec3.hpp"
#include "common/mesh/mesh.hpp"
#include "common/mesh/surface_distance.hpp"

namespace multitetra {

struct TriangleMesh {
  std::vector<Vec3> vertices;  // Finite.
  std::vector<TriangleIndices> triangles;
  // According to the file, vertices are at multiples of 2^-lattice grid steps. Absent if unknown.
  std::optional<int> lattice = std::nullopt;
  // All coordinates in the file are 32-bit floats, so vertices may have been rounded to these.
  bool has_floats = false;
  // According to the file, components with a smaller bounding-box diagonal (samples) were removed.
  double min_component = 0;
  // The unit of the coordinates that the file states, such as "mm"; empty if it states none.
  std::string length_unit = {};
};

struct WeldedMesh {
  // Each vertex is used and has a unique position; each triangle has three different vertices.
  TriangleMesh mesh;
  std::uint64_t degenerate_triangles = 0;  // Removed: two corners coincided.
};

// Returns the corners of each triangle.
[[nodiscard]] std::vector<SurfaceTriangle> triangles_of(const TriangleMesh& mesh);

// Joins vertices at exactly the same position; formats such as STL repeat each corner.
[[nodiscard]] WeldedMesh welded(const TriangleMesh& mesh);

}  // namespace multitetra
