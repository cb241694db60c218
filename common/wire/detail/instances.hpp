// Parts of mesh files that occur several times in different places.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>

#include "common/base/affine.hpp"
#include "common/mesh/triangle_mesh.hpp"
#include "common/wire/mesh_readers.hpp"

namespace multitetra {

// Counts the vertices and triangles of all instances; throws MeshFileError above the limit.
class InstanceCount {
 public:
  void add(std::size_t vertices, std::size_t triangles) {
    if (vertices > kMaxMeshElements - vertices_ || triangles > kMaxMeshElements - triangles_) {
      throw MeshFileError("it has more than 2^28 vertices or triangles, counting all instances");
    }
    vertices_ += vertices;
    triangles_ += triangles;
  }
  void add(const InstanceCount& instance) { add(instance.vertices_, instance.triangles_); }

 private:
  std::size_t vertices_ = 0;
  std::size_t triangles_ = 0;
};

// Appends a part at the place that the map gives it; faces are reversed if the map mirrors.
inline void append(TriangleMesh& mesh, const TriangleMesh& part, const Affine& map) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const Vec3& vertex : part.vertices) mesh.vertices.push_back(map(vertex));
  const bool is_mirrored = map.determinant() < 0;
  for (TriangleIndices corners : part.triangles) {
    for (std::uint32_t& corner : corners) corner += first;
    if (is_mirrored) std::swap(corners[1], corners[2]);
    mesh.triangles.push_back(corners);
  }
}

}  // namespace multitetra
