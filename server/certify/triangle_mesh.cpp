#include "server/certify/triangle_mesh.hpp"

#include <limits>
#include <numeric>

#include <oneapi/tbb/parallel_sort.h>

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
  std::vector<std::uint32_t> order(positions.size());
  std::iota(order.begin(), order.end(), 0U);
  tbb::parallel_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return positions[a] != positions[b] ? positions[a] < positions[b]
                                        : a < b;  // Treats 0 and -0 as equal.
  });
  std::vector<std::uint32_t> first(positions.size());  // First vertex at the same position.
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool is_same = i > 0 && positions[order[i]] == positions[order[i - 1]];
    first[order[i]] = is_same ? first[order[i - 1]] : order[i];
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
