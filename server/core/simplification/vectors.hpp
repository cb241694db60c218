// A little algebra of vectors, for surfaces in space.
#pragma once

#include "common/base/affine.hpp"

namespace multitetra {

[[nodiscard]] constexpr Vec3 difference(const Vec3& a, const Vec3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
[[nodiscard]] constexpr double inner_product(const Vec3& a, const Vec3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
[[nodiscard]] constexpr Vec3 vector_product(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
[[nodiscard]] constexpr double squared_length(const Vec3& a) { return inner_product(a, a); }
// a + t b
[[nodiscard]] constexpr Vec3 moved(const Vec3& a, double t, const Vec3& b) {
  return {a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]};
}

}  // namespace multitetra
