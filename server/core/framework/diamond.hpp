// The shape of a dividing point's diamond, as offsets into an array of samples.
//
// The offsets depend only on which coordinates of the point are odd and, for each of these, on
// which side the odd end of the split edge lies. So there are at most 64 shapes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "server/core/framework/dividing_point.hpp"

namespace multitetra {

// Corner offsets in units of the point's spacing, with coordinates -1, 0 and 1: the ends of the
// split edge, then the link in cyclic order.
struct Diamond {
  static constexpr std::size_t kMaxCorners = 10;

  PointKind kind = PointKind::kEdge;
  std::size_t corners = 0;
  std::array<GridPoint, kMaxCorners> offsets{};
};

// Returns the index of a point's shape. Requires a point in units of its spacing, so at least one
// coordinate is odd.
[[nodiscard]] constexpr std::size_t diamond_index(GridPoint unit_point) {
  const auto bit = [](std::int32_t v, unsigned position) {
    const auto u = static_cast<unsigned>(v);
    // Bit 0: the coordinate is odd. Bit 3: its odd end, in units of 2 spacings, is the upper one.
    return (u & 1U) << position | ((u & 1U) & ((u + 1) >> 1)) << (position + 3);
  };
  return bit(unit_point.x, 0) | bit(unit_point.y, 1) | bit(unit_point.z, 2);
}

[[nodiscard]] constexpr std::array<Diamond, 64> make_diamonds() {
  std::array<Diamond, 64> diamonds{};
  for (int odd = 1; odd < 8; ++odd) {
    for (int upper = 0; upper < 8; ++upper) {
      if ((upper & ~odd) != 0) continue;
      const auto coordinate = [&](int axis) {
        return (odd >> axis & 1) == 0 ? 4 : (upper >> axis & 1) != 0 ? 5 : 3;
      };
      const GridPoint unit_point = {coordinate(0), coordinate(1), coordinate(2)};
      const DividingPoint point(unit_point);
      Diamond& diamond = diamonds[diamond_index(unit_point)];
      diamond.kind = point.kind();
      const auto [a, b] = point.split_edge();
      diamond.offsets[diamond.corners++] = a - unit_point;
      diamond.offsets[diamond.corners++] = b - unit_point;
      const PointList<8> ring = point.ring();
      for (const GridPoint corner : ring) diamond.offsets[diamond.corners++] = corner - unit_point;
    }
  }
  return diamonds;
}

inline constexpr std::array<Diamond, 64> kDiamonds = make_diamonds();

[[nodiscard]] constexpr const Diamond& diamond_of(GridPoint unit_point) {
  return kDiamonds[diamond_index(unit_point)];
}

}  // namespace multitetra
