// A fast sufficient test that the triangles around a vertex do not intersect each other: seen from
// one of a few directions, all turn the same way and go around the vertex once. Then they share
// only the vertex and the edges between neighbours. Requires lattice coordinates within 0 ..
// 2^kMaxLatticeBits.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "common/mesh/lattice.hpp"

namespace multitetra {

// The directions, of a fixed few, from which a triangle with this normal turns left, and those from
// which it turns right: one bit each. Triangles with a common bit turn the same way in that view.
class OrientationMask {
 public:
  OrientationMask() = default;
  explicit OrientationMask(const std::array<std::int64_t, 3>& normal);

  [[nodiscard]] bool any() const { return bits_ != 0; }
  // Returns one of the directions.
  [[nodiscard]] std::size_t direction() const;
  void intersect(const OrientationMask& other) { bits_ &= other.bits_; }

 private:
  std::uint16_t bits_ = 0x3FFF;  // All bits.
};

// Returns whether the triangles (center, around[i], around[i + 1]), cyclic, go around the center
// once. Requires that all turn the same way in each view of `turns`.
[[nodiscard]] bool winds_once(const LatticePoint& center, std::span<const LatticePoint> around,
                              const OrientationMask& turns);

}  // namespace multitetra
