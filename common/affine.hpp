// Vectors and the affine map from one coordinate system to another.
#pragma once

#include <array>
#include <cmath>

namespace multitetra {

using Vec3 = std::array<double, 3>;

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

  // Negative when the map mirrors: triangles must then be turned over to keep their outside.
  [[nodiscard]] constexpr double determinant() const {
    const auto& [a, b, c] = columns;
    return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
           a[2] * (b[0] * c[1] - b[1] * c[0]);
  }

  friend bool operator==(const Affine&, const Affine&) = default;
};

}  // namespace multitetra
