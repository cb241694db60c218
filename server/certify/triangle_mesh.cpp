#include "server/certify/triangle_mesh.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace multitetra {

std::vector<SurfaceTriangle> triangles_of(const TriangleMesh& mesh) {
  std::vector<SurfaceTriangle> triangles;
  triangles.reserve(mesh.triangles.size());
  for (const TriangleIndices& t : mesh.triangles) {
    triangles.push_back({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
  }
  return triangles;
}

WeldedMesh welded(const TriangleMesh& mesh) {
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  const std::vector<Vec3>& positions = mesh.vertices;
  // Sorted together with their positions: indices alone would take twice the time.
  std::vector<std::pair<Vec3, std::uint32_t>> sorted(positions.size());
  for (std::uint32_t i = 0; i < positions.size(); ++i) sorted[i] = {positions[i], i};
  std::sort(sorted.begin(), sorted.end());
  std::vector<std::uint32_t> first(positions.size());  // First vertex at the same position.
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const auto& [position, vertex] = sorted[i];
    const bool is_same = i > 0 && position == sorted[i - 1].first;  // Also 0 and -0.
    first[vertex] = is_same ? first[sorted[i - 1].second] : vertex;
  }
  WeldedMesh result;
  std::vector<std::uint32_t> number(positions.size(), kNone);
  result.mesh.triangles.reserve(mesh.triangles.size());
  for (TriangleIndices t : mesh.triangles) {
    for (std::uint32_t& corner : t) corner = first[corner];
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
      ++result.degenerate_triangles;
      continue;
    }
    for (std::uint32_t& corner : t) {
      if (number[corner] == kNone) {
        number[corner] = static_cast<std::uint32_t>(result.mesh.vertices.size());
        result.mesh.vertices.push_back(positions[corner]);
      }
      corner = number[corner];
    }
    result.mesh.triangles.push_back(t);
  }
  return result;
}

}  // namespace multitetra
