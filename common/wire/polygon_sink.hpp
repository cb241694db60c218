// Cuts the polygons of mesh files into triangles.
#pragma once

#include <cstdint>
#include <vector>

#include "common/wire/mesh_readers.hpp"

namespace multitetra {

// Appends polygons as triangles: convex ones as fans around their first corner, concave ones cut
// ear by ear (Meisters 1975) as seen along their mean normal.
//
//   polygon.begin();
//   for (...) polygon.add(vertex);
//   polygon.end();
class PolygonSink {
 public:
  explicit PolygonSink(TriangleMesh& mesh) : mesh_(mesh) {}

  void begin() { corners_.clear(); }
  // Adds a corner. `vertex` comes unchecked from the file; throws MeshFileError if it is out of
  // range.
  void add(std::int64_t vertex);
  // Appends the triangles: none if there are fewer than three corners. Throws MeshFileError if a
  // polygon of more than four corners crosses itself.
  void end();

 private:
  TriangleMesh& mesh_;
  std::vector<std::uint32_t> corners_;
};

}  // namespace multitetra
