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

// Coordinates in a plane transversal to the direction; any suffice, as only turns matter.
struct Projected {
  Number a = 0, b = 0;
};
Projected project(const LatticePoint& p, std::size_t direction) {
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

}  // namespace

OrientationMask::OrientationMask(const std::array<std::int64_t, 3>& normal) {
  const auto [x, y, z] = normal;
  const std::array<Number, kDirections> along = {x,         y,         z,        x + y + z,
                                                 x + y - z, x - y + z, x - y - z};
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < kDirections; ++i) {
    bits |= static_cast<std::uint32_t>(along[i] > 0) << i;
    bits |= static_cast<std::uint32_t>(along[i] < 0) << (i + kDirections);
  }
  bits_ = static_cast<std::uint16_t>(bits);
}

std::size_t OrientationMask::direction() const {
  return static_cast<std::size_t>(std::countr_zero(bits_)) % kDirections;
}

// Each triangle turns by less than 180 degrees, and all in the same sense. So four cannot go around
// twice, and more go around once if they change between the upper and the lower half twice.
bool winds_once(const LatticePoint& center, std::span<const LatticePoint> around,
                const OrientationMask& turns) {
  if (around.size() <= 4) return true;
  const std::size_t direction = turns.direction();
  const auto is_in_upper_half = [&](const LatticePoint& p) {
    const Projected at = project(from_to(center, p), direction);
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

}  // namespace multitetra
