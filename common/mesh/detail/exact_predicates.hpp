// Orientation predicates without rounding errors: the exact sign of a determinant, computed in
// double where that is conclusive.
#pragma once

#include <array>

#include "common/base/vec3.hpp"

namespace multitetra {

using Vec2 = std::array<double, 2>;

// Returns the sign (1, 0 or -1) of det(a - d, b - d, c - d). It is positive if d lies below the
// plane in which a, b, c turn counterclockwise seen from above. Requires finite coordinates.
[[nodiscard]] int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

// Returns 1 if a, b, c turn counterclockwise, -1 if clockwise, 0 if they are collinear.
[[nodiscard]] int orientation(const Vec2& a, const Vec2& b, const Vec2& c);

}  // namespace multitetra
