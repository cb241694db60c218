// The points of one layer by spacing and kind, as bits: which of them have values on both sides of
// the isovalue in their diamond, and which have children with a bit.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "server/core/fine_errors/detail/cell_bits.hpp"
#include "server/core/framework/dividing_point.hpp"

namespace multitetra {

// The points of a cell's layers, of spacing 1, 2 and 4, whose diamonds have values of both signs.
[[nodiscard]] std::array<BitPlane, 8> mixed_diamonds(const BitGrid& above, const BitGrid& below,
                                                     std::size_t cell);

// The points of layer z of that kind and of spacing 2^exponent, which divides z and is at most 4.
[[nodiscard]] BitPlane points_of_kind(PointKind kind, std::int32_t z, int exponent);

// Those with at least one child that has a bit.
[[nodiscard]] BitPlane with_children(const BitGrid& bits, std::size_t cell, std::int32_t z,
                                     int exponent, PointKind kind);

}  // namespace multitetra
