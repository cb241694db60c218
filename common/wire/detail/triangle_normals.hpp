// Normals of triangles for mesh files.
#pragma once

#include <array>
#include <cmath>

#include "common/base/vec3.hpp"

namespace multitetra {

// Returns the normal by the right-hand rule, times twice the area.
[[nodiscard]] inline Vec3 area_vector(const Vec3& a, const Vec3& b, const Vec3& c) {
  return cross(difference(b, a), difference(c, a));
}

// Returns the vector scaled to length 1, or the z axis for a zero vector.
[[nodiscard]] inline std::array<float, 3> unit_or_upwards(const Vec3& v) {
  const double length = std::hypot(v[0], v[1], v[2]);
  if (!(length > 0)) return {0, 0, 1};
  return {static_cast<float>(v[0] / length), static_cast<float>(v[1] / length),
          static_cast<float>(v[2] / length)};
}

}  // namespace multitetra
