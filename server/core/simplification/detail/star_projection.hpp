// A quick proof that the triangles around a vertex do not intersect each other.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "common/mesh/lattice.hpp"

namespace multitetra {

// From which directions, of a few, a triangle with this normal is seen turning left, and from which
// right: a bit for each. Triangles that have a bit in common turn the same way there.
class SeenTurns {
 public:
  SeenTurns() = default;
  explicit SeenTurns(const std::array<std::int64_t, 3>& normal);

  [[nodiscard]] bool any() const { return bits_ != 0; }
  // One of the directions.
  [[nodiscard]] std::size_t direction() const;
  void meet(const SeenTurns& other) { bits_ &= other.bits_; }

 private:
  std::uint16_t bits_ = 0x3FFF;  // All.
};

// Whether the triangles (centre, around[i], around[i + 1]), cyclic, which all turn the same way
// when seen from a direction of `turns`, go once around the centre.
[[nodiscard]] bool go_around_once(const LatticePoint& centre, std::span<const LatticePoint> around,
                                  const SeenTurns& turns);

// Whether the triangles (centre, around[i], around[i + 1]), cyclic, are seen side by side from some
// direction: all turn the same way, and go once around the centre. Then they have nothing in common
// but the centre and the edges between neighbours. A few directions are tried; false proves
// nothing. Lattice coordinates are within 0 .. 2^kMaxLatticeBits.
[[nodiscard]] bool lie_side_by_side(const LatticePoint& centre,
                                    std::span<const LatticePoint> around);

}  // namespace multitetra
