// The self-intersections of a mesh. Exact: no result depends on rounding.
#pragma once

#include <cstdint>

#include "server/certify/triangle_mesh.hpp"

namespace multitetra {

struct SelfIntersections {
  std::uint64_t triangles = 0;  // Triangles that intersect another one.
  std::uint64_t pairs = 0;
  std::uint64_t flat_triangles = 0;  // Without area: they are left out.
  Vec3 place = {0, 0, 0};            // The middle of the first triangle that intersects another.
};

// Triangles intersect that have a point in common which is neither a vertex nor on an edge of both:
// neighbours do where they overlap, others also where they only touch. The same for any number of
// threads. Requires a welded mesh.
[[nodiscard]] SelfIntersections self_intersections(const TriangleMesh& mesh);

}  // namespace multitetra
