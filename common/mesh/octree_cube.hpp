// An aligned cube of the grid with side 2^exponent grid steps, located at (x, y, z) times its side.
// Identifies a tile.
#pragma once

#include <compare>
#include <cstdint>
#include <string>

#include "common/mesh/lattice.hpp"

namespace multitetra {

struct OctreeCube {
  // The side is 2^exponent grid steps; 0 to kMaxLatticeBits.
  std::int32_t exponent = 0;
  std::int32_t x = 0;  // The position in units of the side.
  std::int32_t y = 0;
  std::int32_t z = 0;

  [[nodiscard]] constexpr std::int32_t side() const { return std::int32_t{1} << exponent; }
  [[nodiscard]] constexpr OctreeCube parent() const {
    return {exponent + 1, x >> 1, y >> 1, z >> 1};
  }
  // Returns child `index` in 0..7: bit 0 selects the upper half in x, bit 1 in y, bit 2 in z.
  [[nodiscard]] constexpr OctreeCube child(int index) const {
    return {exponent - 1, 2 * x + (index & 1), 2 * y + (index >> 1 & 1), 2 * z + (index >> 2 & 1)};
  }
  // Returns whether the lattice point of resolution r lies in the closed cube.
  [[nodiscard]] constexpr bool contains(const LatticePoint& p, int resolution) const {
    const auto within = [this, resolution](std::int32_t value, std::int32_t position) {
      const std::int64_t low = static_cast<std::int64_t>(position) << (exponent + resolution);
      const std::int64_t high = low + (std::int64_t{1} << (exponent + resolution));
      return value >= low && value <= high;
    };
    return within(p.x, x) && within(p.y, y) && within(p.z, z);
  }

  friend constexpr auto operator<=>(const OctreeCube&, const OctreeCube&) = default;
};

// For logs and error texts, such as "cube 5:3/0/7" (exponent, then x/y/z).
[[nodiscard]] inline std::string to_string(const OctreeCube& cube) {
  return "cube " + std::to_string(cube.exponent) + ":" + std::to_string(cube.x) + "/" +
         std::to_string(cube.y) + "/" + std::to_string(cube.z);
}

}  // namespace multitetra
