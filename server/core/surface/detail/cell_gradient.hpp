// The gradient of a field inside a cell of unit side, interpolated trilinearly from central
// differences at its corners. See vertex_normals.hpp.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "common/mesh/lattice.hpp"
#include "server/core/framework/field.hpp"

namespace multitetra {

// The position of a vertex in its unit cell. Along an axis, `corners` is 2 with the weights below
// if the vertex lies between two unit points, or 1 if it lies on one.
struct PlaceInCell {
  GridPoint cell;  // Lowest corner, in units.
  std::array<int, 3> corners{};
  std::array<std::array<double, 2>, 3> weights{};
};

// Returns the position of p in units of 2^exponent lattice steps.
[[nodiscard]] inline PlaceInCell place_of(const LatticePoint& p, int exponent) {
  PlaceInCell place{.cell = {p.x >> exponent, p.y >> exponent, p.z >> exponent}};
  const double step = 1.0 / static_cast<double>(1 << exponent);
  const std::array<std::int32_t, 3> at = {p.x, p.y, p.z};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int32_t beyond = at[axis] & ((1 << exponent) - 1);
    place.corners[axis] = beyond == 0 ? 1 : 2;
    place.weights[axis] = {1 - beyond * step, beyond * step};
  }
  return place;
}

// The values at the corners of a cell and one unit around them, as the differences need them.
class CellNeighbourhood {
 public:
  // x, y, z = 0 is one unit below the cell's lowest corner.
  static constexpr std::size_t index(int x, int y, int z) {
    return static_cast<std::size_t>(x + kRow * y + kSlice * z);
  }
  static constexpr std::array<std::size_t, 3> kStep = {1, 4, 16};

  // Calls `value(x, y, z)` for the needed samples only.
  template <typename Value>
  void fill(const std::array<int, 3>& corners, const Value& value) {
    for (int z = 0; z < corners[2] + 2; ++z) {
      const bool beyond_z = z == 0 || z == corners[2] + 1;
      for (int y = 0; y < corners[1] + 2; ++y) {
        const bool beyond_y = y == 0 || y == corners[1] + 1;
        if (beyond_y && beyond_z) continue;
        const int margin = beyond_y || beyond_z ? 1 : 0;
        for (int x = margin; x < corners[0] + 2 - margin; ++x) {
          values_[index(x, y, z)] = value(x, y, z);
        }
      }
    }
  }

  // Returns the gradient at the vertex, per unit.
  [[nodiscard]] Vec3 gradient(const PlaceInCell& place) const {
    const Float4 plain = central_gradient(place);
    const float total = plain[0] + plain[1] + plain[2] + plain[3];
    const bool is_finite = total - total == 0;
    return is_finite ? Vec3{static_cast<double>(plain[0]), static_cast<double>(plain[1]),
                            static_cast<double>(plain[2])}
                     : gradient_without_void(place);
  }

 private:
  using Float4 = float __attribute__((vector_size(16)));
  static constexpr int kRow = 4;
  static constexpr int kSlice = 16;

  // Computes all axes at once. Not finite if a value is void or a difference overflows.
  [[nodiscard]] Float4 central_gradient(const PlaceInCell& place) const {
    Float4 sum = {};
    for (int z = 0; z < place.corners[2]; ++z) {
      for (int y = 0; y < place.corners[1]; ++y) {
        const double weight_yz = place.weights[1][static_cast<std::size_t>(y)] *
                                 place.weights[2][static_cast<std::size_t>(z)];
        for (int x = 0; x < place.corners[0]; ++x) {
          const float* const v = &values_[index(x + 1, y + 1, z + 1)];
          const auto half_weight =
              static_cast<float>(0.5 * place.weights[0][static_cast<std::size_t>(x)] * weight_yz);
          // Makes the sum NaN also at a void corner without void neighbours.
          const float here = v[0] - v[0];
          const Float4 above = {v[1], v[kRow], v[kSlice], here};
          const Float4 below = {v[-1], v[-kRow], v[-kSlice], here};
          sum += half_weight * (above - below);
        }
      }
    }
    return sum;
  }

  [[nodiscard]] Vec3 gradient_without_void(const PlaceInCell& place) const {
    Vec3 sum = {0, 0, 0};
    for (int z = 0; z < place.corners[2]; ++z) {
      for (int y = 0; y < place.corners[1]; ++y) {
        for (int x = 0; x < place.corners[0]; ++x) {
          const std::size_t at = index(x + 1, y + 1, z + 1);
          if (is_void(values_[at])) continue;
          const double weight = place.weights[0][static_cast<std::size_t>(x)] *
                                place.weights[1][static_cast<std::size_t>(y)] *
                                place.weights[2][static_cast<std::size_t>(z)];
          for (std::size_t axis = 0; axis < 3; ++axis) {
            sum[axis] +=
                weight * slope(values_[at - kStep[axis]], values_[at], values_[at + kStep[axis]]);
          }
        }
      }
    }
    return sum;
  }

  static double slope(float below, float here, float above) {
    const auto difference = [](float a, float b) {
      return static_cast<double>(b) - static_cast<double>(a);
    };
    if (!is_void(below) && !is_void(above)) return 0.5 * difference(below, above);
    if (!is_void(above)) return difference(here, above);
    return is_void(below) ? 0 : difference(below, here);
  }

  std::array<float, 64> values_;
};

}  // namespace multitetra
