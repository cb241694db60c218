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
  // Comparisons of corners that all concave polygons may take: some ten seconds.
  static constexpr std::uint64_t kMaxComparisons = std::uint64_t{1} << 31;

  explicit PolygonSink(TriangleMesh& mesh, std::uint64_t max_comparisons = kMaxComparisons)
      : mesh_(mesh), comparisons_left_(max_comparisons) {}

  void begin() { corners_.clear(); }
  // Adds a corner. `vertex` comes unchecked from the file; throws MeshFileError if it is out of
  // range.
  void add(std::int64_t vertex);
  // Appends the triangles: none if there are fewer than three corners. Throws MeshFileError if a
  // polygon of more than four corners crosses itself, or if all together take too long.
  void end();

 private:
  TriangleMesh& mesh_;
  std::vector<std::uint32_t> corners_;
  std::uint64_t comparisons_left_;
};

}  // namespace multitetra
