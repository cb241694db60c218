// On which side points lie, without rounding errors: the sign of a determinant of the coordinates
// as they are. Computed in double where that decides, else exactly.
#pragma once

#include <array>

#include "common/base/vec3.hpp"

namespace multitetra {

using Vec2 = std::array<double, 2>;

// 1, 0 or -1: the sign of det(a - d, b - d, c - d), positive when d lies below the plane in which
// a, b, c turn counter-clockwise seen from above. Requires finite coordinates.
[[nodiscard]] int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

// Positive when a, b, c turn counter-clockwise.
[[nodiscard]] int orientation(const Vec2& a, const Vec2& b, const Vec2& c);

}  // namespace multitetra
