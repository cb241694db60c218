// Self-intersections of a mesh. Exact: no result depends on rounding.
#pragma once

#include <cstdint>

#include "common/mesh/triangle_mesh.hpp"

namespace multitetra {

struct SelfIntersections {
  std::uint64_t triangles = 0;  // Triangles that intersect another one.
  std::uint64_t pairs = 0;
  std::uint64_t flat_triangles = 0;  // Without area; they are ignored.
  Vec3 place = {0, 0, 0};            // The middle of the first intersecting triangle.
};

// Two triangles intersect if they share a point that lies neither on a common vertex nor on a
// common edge: neighbors if they overlap, others also if they only touch. Returns the same result
// for any number of threads. Requires a welded mesh. Throws Cancelled soon after `stop` is
// triggered.
[[nodiscard]] SelfIntersections self_intersections(const TriangleMesh& mesh,
                                                   const std::stop_token& stop = {});

}  // namespace multitetra
