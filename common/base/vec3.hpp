// Vectors in three dimensions.
#pragma once

#include <array>
#include <cmath>

namespace multitetra {

using Vec3 = std::array<double, 3>;

[[nodiscard]] constexpr Vec3 vec3(const std::array<float, 3>& v) { return {v[0], v[1], v[2]}; }

[[nodiscard]] constexpr Vec3 sum(const Vec3& a, const Vec3& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
[[nodiscard]] constexpr Vec3 difference(const Vec3& a, const Vec3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
[[nodiscard]] constexpr Vec3 scaled(const Vec3& v, double factor) {
  return {v[0] * factor, v[1] * factor, v[2] * factor};
}
// a + t b
[[nodiscard]] constexpr Vec3 moved(const Vec3& a, double t, const Vec3& b) {
  return {a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]};
}
[[nodiscard]] constexpr double dot(const Vec3& a, const Vec3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
[[nodiscard]] constexpr Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
[[nodiscard]] constexpr double squared_length(const Vec3& v) { return dot(v, v); }
[[nodiscard]] inline double length(const Vec3& v) { return std::sqrt(dot(v, v)); }

}  // namespace multitetra
