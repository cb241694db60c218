// The affine map from one coordinate system to another.
#pragma once

#include <array>

#include "common/base/vec3.hpp"

namespace multitetra {

// x -> columns[0] x[0] + columns[1] x[1] + columns[2] x[2] + translation.
struct Affine {
  std::array<Vec3, 3> columns = {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  Vec3 translation = {0, 0, 0};

  [[nodiscard]] constexpr Vec3 operator()(const Vec3& x) const {
    Vec3 y = translation;
    for (std::size_t column = 0; column < 3; ++column) {
      for (std::size_t row = 0; row < 3; ++row) y[row] += columns[column][row] * x[column];
    }
    return y;
  }

  // Negative if the map mirrors: triangles must then be reversed to keep their outside.
  [[nodiscard]] constexpr double determinant() const {
    const auto& [a, b, c] = columns;
    return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
           a[2] * (b[0] * c[1] - b[1] * c[0]);
  }

  friend bool operator==(const Affine&, const Affine&) = default;
};

// x -> outer(inner(x))
[[nodiscard]] constexpr Affine composed(const Affine& outer, const Affine& inner) {
  Affine map;
  map.translation = outer(inner.translation);
  for (std::size_t column = 0; column < 3; ++column) {
    for (std::size_t row = 0; row < 3; ++row) {
      map.columns[column][row] = outer.columns[0][row] * inner.columns[column][0] +
                                 outer.columns[1][row] * inner.columns[column][1] +
                                 outer.columns[2][row] * inner.columns[column][2];
    }
  }
  return map;
}

// Requires a determinant other than 0.
[[nodiscard]] constexpr Affine inverse(const Affine& map) {
  const double d = map.determinant();
  Affine back;
  for (std::size_t row = 0; row < 3; ++row) {
    // Row i of the inverse is the cross product of the other two columns / determinant.
    const Vec3& b = map.columns[(row + 1) % 3];
    const Vec3& c = map.columns[(row + 2) % 3];
    for (std::size_t column = 0; column < 3; ++column) {
      const std::size_t next = (column + 1) % 3;
      const std::size_t last = (column + 2) % 3;
      back.columns[column][row] = (b[next] * c[last] - b[last] * c[next]) / d;
    }
  }
  back.translation = {0, 0, 0};
  const Vec3 moved = back(map.translation);
  back.translation = {-moved[0], -moved[1], -moved[2]};
  return back;
}

}  // namespace multitetra
