// Cuts the polygons of mesh files into triangles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "common/wire/mesh_readers.hpp"

namespace multitetra {

// Appends polygons as triangle fans around their first corner.
class PolygonSink {
 public:
  explicit PolygonSink(TriangleMesh& mesh) : mesh_(mesh) {}

  void begin() { count_ = 0; }
  // Adds a corner. `vertex` comes unchecked from the file; throws MeshFileError if it is out of
  // range.
  void add(std::int64_t vertex) {
    if (vertex < 0 || vertex >= static_cast<std::int64_t>(mesh_.vertices.size())) {
      throw MeshFileError("a face has the vertex " + std::to_string(vertex) + " of " +
                          std::to_string(mesh_.vertices.size()));
    }
    if (count_ >= kMaxPolygonCorners) {
      throw MeshFileError("a face has more than " + std::to_string(kMaxPolygonCorners) +
                          " corners");
    }
    const auto corner = static_cast<std::uint32_t>(vertex);
    if (count_ == 0) first_ = corner;
    if (count_ >= 2) mesh_.triangles.push_back({first_, last_, corner});
    last_ = corner;
    ++count_;
  }

 private:
  TriangleMesh& mesh_;
  std::size_t count_ = 0;
  std::uint32_t first_ = 0;
  std::uint32_t last_ = 0;
};

}  // namespace multitetra
