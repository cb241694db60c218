// The grid of the framework: points (x, y, z) with 0 <= x, y, z <= n, n = 2^N. It is virtual: only
// the extent of the data is stored.
#pragma once

#include <cassert>
#include <compare>
#include <cstdint>

#include "common/mesh/lattice.hpp"

namespace multitetra {

struct GridPoint {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;

  friend constexpr auto operator<=>(const GridPoint&, const GridPoint&) = default;
  friend constexpr GridPoint operator+(GridPoint a, GridPoint b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  friend constexpr GridPoint operator-(GridPoint a, GridPoint b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  friend constexpr GridPoint operator*(std::int32_t factor, GridPoint a) {
    return {factor * a.x, factor * a.y, factor * a.z};
  }
  // Returns the coordinate along axis 0, 1 or 2.
  [[nodiscard]] constexpr std::int32_t operator[](int axis) const {
    return axis == 0 ? x : axis == 1 ? y : z;
  }
};

[[nodiscard]] constexpr GridPoint midpoint(GridPoint a, GridPoint b) {
  return {(a.x + b.x) / 2, (a.y + b.y) / 2, (a.z + b.z) / 2};
}

// Returns the unit step along axis 0, 1 or 2.
[[nodiscard]] constexpr GridPoint unit(int axis) {
  return {axis == 0 ? 1 : 0, axis == 1 ? 1 : 0, axis == 2 ? 1 : 0};
}

// Returns six times the signed volume of the tetrahedron p, q, r, s: positive if q, r, s turn
// counter-clockwise seen from the side away from p. Exact for points of any grid.
[[nodiscard]] constexpr std::int64_t six_times_volume(GridPoint p, GridPoint q, GridPoint r,
                                                      GridPoint s) {
  const GridPoint a = q - p;
  const GridPoint b = r - p;
  const GridPoint c = s - p;
  const auto product = [](std::int64_t x, std::int64_t y) { return x * y; };
  return a.x * (product(b.y, c.z) - product(b.z, c.y)) -
         a.y * (product(b.x, c.z) - product(b.z, c.x)) +
         a.z * (product(b.x, c.y) - product(b.y, c.x));
}

// Returns the largest power of two that divides all coordinates. Requires p other than the origin.
[[nodiscard]] constexpr std::int32_t spacing_of(GridPoint p) {
  const std::int32_t bits = p.x | p.y | p.z;
  return bits & -bits;
}

class Grid {
 public:
  // Requires 1 <= exponent < kMaxLatticeBits.
  explicit constexpr Grid(int exponent) : exponent_(exponent) {
    assert(exponent >= 1 && exponent < kMaxLatticeBits);
  }

  [[nodiscard]] constexpr int exponent() const { return exponent_; }            // N
  [[nodiscard]] constexpr std::int32_t side() const { return 1 << exponent_; }  // n = 2^N steps
  [[nodiscard]] constexpr bool contains(GridPoint p) const {
    const auto within = [this](std::int32_t v) { return v >= 0 && v <= side(); };
    return within(p.x) && within(p.y) && within(p.z);
  }

 private:
  int exponent_;
};

}  // namespace multitetra
