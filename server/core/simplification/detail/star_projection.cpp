#include "server/core/simplification/detail/star_projection.hpp"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace multitetra {
namespace {

using Number = std::int64_t;

// The axes and the diagonals of a cube.
constexpr std::size_t kDirections = 7;
constexpr std::uint32_t kAll = (1U << kDirections) - 1;

// Two coordinates in a plane seen from the direction: any will do, as only turns are counted.
struct Seen {
  Number a = 0, b = 0;
};
Seen seen(const LatticePoint& p, std::size_t direction) {
  switch (direction) {
    case 0:
      return {p.y, p.z};
    case 1:
      return {p.z, p.x};
    case 2:
      return {p.x, p.y};
    case 3:
      return {Number{p.x} - p.y, Number{p.y} - p.z};  // Along (1, 1, 1)
    case 4:
      return {Number{p.x} - p.y, Number{p.y} + p.z};  // (1, 1, -1)
    case 5:
      return {Number{p.x} + p.y, Number{p.y} + p.z};  // (1, -1, 1)
    default:
      return {Number{p.x} + p.y, Number{p.y} - p.z};  // (1, -1, -1)
  }
}

LatticePoint from_to(const LatticePoint& from, const LatticePoint& to) {
  return {to.x - from.x, to.y - from.y, to.z - from.z};
}

// Bits of the directions in which a product is above 0, and below.
struct Turns {
  std::uint32_t above = kAll, below = kAll;

  void meet(const LatticePoint& p, const LatticePoint& q) {
    const Number x = Number{p.y} * q.z - Number{p.z} * q.y;
    const Number y = Number{p.z} * q.x - Number{p.x} * q.z;
    const Number z = Number{p.x} * q.y - Number{p.y} * q.x;
    const std::array<Number, kDirections> along = {x,         y,         z,        x + y + z,
                                                   x + y - z, x - y + z, x - y - z};
    std::uint32_t is_above = 0, is_below = 0;
    for (std::size_t i = 0; i < kDirections; ++i) {
      is_above |= static_cast<std::uint32_t>(along[i] > 0) << i;
      is_below |= static_cast<std::uint32_t>(along[i] < 0) << i;
    }
    above &= is_above;
    below &= is_below;
  }
};

// Each triangle turns by less than half a circle, and all in the same sense: they go around once if
// they change between the upper half and the lower one twice.
bool go_around_once(const LatticePoint& centre, std::span<const LatticePoint> around,
                    std::size_t direction) {
  const auto is_in_upper_half = [&](const LatticePoint& p) {
    const Seen at = seen(from_to(centre, p), direction);
    return at.b > 0 || (at.b == 0 && at.a > 0);
  };
  bool was_upper = is_in_upper_half(around.back());
  int changes = 0;
  for (const LatticePoint& p : around) {
    const bool is_upper = is_in_upper_half(p);
    changes += is_upper != was_upper ? 1 : 0;
    was_upper = is_upper;
  }
  return changes == 2;
}

}  // namespace

bool lie_side_by_side(const LatticePoint& centre, std::span<const LatticePoint> around) {
  Turns turns;
  LatticePoint before = from_to(centre, around.back());
  for (const LatticePoint& p : around) {
    const LatticePoint at = from_to(centre, p);
    turns.meet(before, at);
    if ((turns.above | turns.below) == 0) return false;
    before = at;
  }
  const auto direction = static_cast<std::size_t>(std::countr_zero(turns.above | turns.below));
  return go_around_once(centre, around, direction);
}

}  // namespace multitetra
