// World lengths of steps between grid points.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "common/base/affine.hpp"
#include "server/core/framework/grid.hpp"

namespace multitetra {

// The world lengths of the 26 steps from a grid point to its neighbours.
class GridStepLengths {
 public:
  explicit GridStepLengths(const Vec3& spacing) {
    for (int code = 0; code < 27; ++code) {
      const std::array<int, 3> step = {code % 3 - 1, code / 3 % 3 - 1, code / 9 - 1};
      double square = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double along = step[axis] * spacing[axis];
        square += along * along;
      }
      lengths_[static_cast<std::size_t>(code)] = std::sqrt(square);
    }
  }
  // Returns the length of `offset`, whose coordinates are each 0 or +-spacing.
  [[nodiscard]] double operator()(GridPoint offset, std::int32_t spacing) const {
    const auto sign = [](std::int32_t v) { return v > 0 ? 2 : v < 0 ? 0 : 1; };
    return spacing * lengths_[static_cast<std::size_t>(sign(offset.x) + 3 * sign(offset.y) +
                                                       9 * sign(offset.z))];
  }

 private:
  std::array<double, 27> lengths_{};
};

}  // namespace multitetra
