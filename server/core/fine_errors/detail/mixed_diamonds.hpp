// Bit masks of a layer's points: those whose diamond has values on both sides of the isovalue, and
// those that have children with a set bit.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "server/core/fine_errors/detail/cell_bits.hpp"
#include "server/core/framework/dividing_point.hpp"

namespace multitetra {

// Returns the points of spacing 1, 2 and 4 in a cell's layers whose diamonds have values on both
// sides of the isovalue.
[[nodiscard]] std::array<BitPlane, 8> mixed_diamonds(const BitGrid& above, const BitGrid& below,
                                                     std::size_t cell);

// Returns the points of layer z of this kind and of spacing 2^exponent <= 4, which divides z.
[[nodiscard]] BitPlane points_of_kind(PointKind kind, std::int32_t z, int exponent);

// Returns those of these points that have a child with a set bit.
[[nodiscard]] BitPlane with_children(const BitGrid& bits, std::size_t cell, std::int32_t z,
                                     int exponent, PointKind kind);

}  // namespace multitetra
