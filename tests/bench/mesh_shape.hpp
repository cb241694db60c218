// The connectivity of a mesh; vertices are identified by their indices.
#pragma once

#include <cstdint>

#include "common/base/vec3.hpp"
#include "tests/bench/plain_mesh.hpp"

namespace multitetra {

struct Shape {
  std::int64_t open_edges = 0;  // Edges not on the data's border.
  std::int64_t nonmanifold_edges = 0;
  std::int64_t euler_characteristic = 0;
  std::int64_t components = 0;
};

// The data's box begins at the origin and ends at `high`; an edge lies on its border if both ends
// are at most `border` inside one of its sides.
[[nodiscard]] Shape shape_of(const PlainMesh& mesh, const Vec3& high, double border);

}  // namespace multitetra
