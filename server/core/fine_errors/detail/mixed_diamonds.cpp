#include "server/core/fine_errors/detail/mixed_diamonds.hpp"

namespace multitetra {
namespace {

// Bits of those of eight points in a row with spacing 2^[i] and an even or an odd coordinate.
constexpr unsigned kPositions[3][2] = {{0x55, 0xAA}, {0x11, 0x44}, {0x01, 0x10}};

// The points of a layer by the axes, x and y, along which they are odd in units of the spacing.
struct Parities {
  BitPlane none = 0;
  BitPlane x = 0;
  BitPlane y = 0;
  BitPlane both = 0;
};
constexpr std::array<Parities, 3> kParities = [] {
  std::array<Parities, 3> parities{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [even, odd] = kPositions[i];
    parities[i] = {.none = plane_of(even, even),
                   .x = plane_of(odd, even),
                   .y = plane_of(even, odd),
                   .both = plane_of(odd, odd)};
  }
  return parities;
}();

bool is_odd(std::int32_t z, int exponent) { return (z >> exponent & 1) != 0; }

// Returns the points of spacing 2^exponent with a bit in their diamond, given the bits in layer z
// and in the layers one spacing below and above it. See DividingPoint: the link of an edge lies
// across it, that of a face in its plane and on its normal; that of a cube consists of corners.
BitPlane with_diamonds(const BitGrid::Around& low, const BitGrid::Around& in,
                       const BitGrid::Around& high, std::int32_t z, int exponent) {
  const BitPlane z_here = low.here | high.here;
  const BitPlane z_x = low.along_x | high.along_x;
  const BitPlane z_y = low.along_y | high.along_y;
  const BitPlane across = in.along_x | in.along_y;
  const Parities& odd = kParities[static_cast<std::size_t>(exponent)];
  if (is_odd(z, exponent)) {
    return ((in.here | z_here | across | in.diagonal) & odd.none) |
           ((in.here | z_x | in.along_y) & odd.x) | ((in.here | z_y | in.along_x) & odd.y) |
           ((in.here | low.diagonal | high.diagonal) & odd.both);
  }
  return ((in.here | across | z_here | z_y) & odd.x) | ((in.here | across | z_here | z_x) & odd.y) |
         ((in.here | in.diagonal | z_here) & odd.both);
}

}  // namespace

std::array<BitPlane, 8> mixed_diamonds(const BitGrid& above, const BitGrid& below,
                                       std::size_t cell) {
  std::array<BitPlane, 8> mixed{};
  for (int exponent = 0; exponent < 3; ++exponent) {
    const int step = 1 << exponent;
    const auto in_layers = [&](const BitGrid& bits, const auto& take) {
      BitGrid::Around low = bits.around(cell, -step, step);
      BitGrid::Around in = bits.around(cell, 0, step);
      for (std::int32_t z = 0; z < 8; z += step) {
        const BitGrid::Around high = bits.around(cell, z + step, step);
        take(static_cast<std::size_t>(z), with_diamonds(low, in, high, z, exponent));
        low = in;
        in = high;
      }
    };
    std::array<BitPlane, 8> with_above{};
    in_layers(above, [&](std::size_t z, BitPlane points) { with_above[z] = points; });
    in_layers(below, [&](std::size_t z, BitPlane points) { mixed[z] |= with_above[z] & points; });
  }
  return mixed;
}

BitPlane points_of_kind(PointKind kind, std::int32_t z, int exponent) {
  const Parities& odd = kParities[static_cast<std::size_t>(exponent)];
  const bool odd_z = is_odd(z, exponent);
  switch (kind) {
    case PointKind::kEdge:
      return odd_z ? odd.none : odd.x | odd.y;
    case PointKind::kFace:
      return odd_z ? odd.x | odd.y : odd.both;
    case PointKind::kCube:
      break;
  }
  return odd_z ? odd.both : 0;
}

BitPlane with_children(const BitGrid& bits, std::size_t cell, std::int32_t z, int exponent,
                       PointKind kind) {
  const Parities& odd = kParities[static_cast<std::size_t>(exponent)];
  const int step = 1 << exponent;
  if (kind == PointKind::kEdge) {  // The centers of the eight adjacent cubes of half the size.
    if (exponent == 0) return 0;
    const int half = step / 2;
    return (bits.around(cell, z - half, half).diagonal |
            bits.around(cell, z + half, half).diagonal) &
           points_of_kind(kind, z, exponent);
  }
  // The edges of a face or the faces of a cube: one step along each odd axis of the point.
  const BitGrid::Around in = bits.around(cell, z, step);
  const BitPlane in_layer = in.along_x | in.along_y;
  if (!is_odd(z, exponent)) return kind == PointKind::kFace ? in_layer & odd.both : 0;
  const BitPlane along_z = bits.layer(cell, z - step) | bits.layer(cell, z + step);
  if (kind == PointKind::kCube) return (in_layer | along_z) & odd.both;
  return ((in.along_x | along_z) & odd.x) | ((in.along_y | along_z) & odd.y);
}

}  // namespace multitetra
