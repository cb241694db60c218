// The lattice on which all vertices lie.
//
// Grid points have integer coordinates. Every edge of the framework is divided into steps of
// delta = 2^-r grid steps, and a vertex lies at one of the divisions, never at an end. So a vertex
// is three integers, its "lattice coordinates" (grid coordinates times 2^r), it lies exactly on its
// edge, and vertices on different edges differ. Equal integers mean the same vertex: tiles are
// welded by comparison, and rounding cannot open cracks.
//
//   grid step      |-------------------------------|
//   lattice, r = 3 |   .   .   .   .   .   .   .   |    2^3 lattice steps to a grid step
#pragma once

#include <compare>
#include <cstdint>

#include "common/base/affine.hpp"

namespace multitetra {

// r: there are 2^r lattice steps per grid step. A grid of 2^N steps per side has lattice
// coordinates from 0 to 2^(N + r).
inline constexpr int kMinLatticeResolution = 1;
inline constexpr int kMaxLatticeResolution = 8;
inline constexpr int kDefaultLatticeResolution = 5;
inline constexpr int kMaxLatticeBits = 20;  // N + r never exceeds this.

struct LatticePoint {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;

  friend constexpr auto operator<=>(const LatticePoint&, const LatticePoint&) = default;

  // Returns all coordinates in one integer that orders by (z, y, x): 21 bits each, x lowest.
  // Requires 0 <= x, y, z < 2^21.
  [[nodiscard]] constexpr std::uint64_t key() const {
    return static_cast<std::uint64_t>(x) | static_cast<std::uint64_t>(y) << 21 |
           static_cast<std::uint64_t>(z) << 42;
  }
};

[[nodiscard]] constexpr bool is_on_lattice(const LatticePoint& p) {
  constexpr std::int32_t kLimit = std::int32_t{1} << kMaxLatticeBits;
  return p.x >= 0 && p.y >= 0 && p.z >= 0 && p.x <= kLimit && p.y <= kLimit && p.z <= kLimit;
}

// Converts lattice coordinates to grid coordinates.
[[nodiscard]] constexpr Vec3 grid_coordinates(const LatticePoint& p, int resolution) {
  const double delta = 1.0 / static_cast<double>(1 << resolution);
  return {p.x * delta, p.y * delta, p.z * delta};
}

}  // namespace multitetra
