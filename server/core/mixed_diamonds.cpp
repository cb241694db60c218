#include "server/core/mixed_diamonds.hpp"

#include <cstring>

namespace multitetra {
namespace {

constexpr std::int32_t kCell = 8;
using Rows4 = std::uint32_t __attribute__((vector_size(16)));

// The points of spacing 2^exponent in the rows y, y + 2, y + 4 and y + 6 of the layer z.
Rows4 mixed_in_rows(const SignRows& rows, int exponent, std::int32_t y, std::int32_t z) {
  Rows4 mixed{};
  for (const PointKind kind : {PointKind::kEdge, PointKind::kFace, PointKind::kCube}) {
    const RowKind& shape = row_kind(kind, y >> exponent, z >> exponent);
    if (!shape.exists) continue;
    Rows4 above{};
    Rows4 below{};
    for (const GridPoint offset : shape.diamond) {
      const std::int32_t at_y = y + offset.y * (1 << exponent);
      const std::int32_t at_z = z + offset.z * (1 << exponent);
      Rows4 of_above;
      Rows4 of_below;
      std::memcpy(&of_above, rows.above(at_y, at_z), sizeof(of_above));
      std::memcpy(&of_below, rows.below(at_y, at_z), sizeof(of_below));
      const int shift = kCell + offset.x * (1 << exponent);
      above |= of_above >> shift;
      below |= of_below >> shift;
    }
    mixed |= above & below & kPositions[static_cast<std::size_t>(exponent)][shape.odd_x];
  }
  return mixed;
}

}  // namespace

std::array<std::uint8_t, 64> mixed_diamonds(const SignRows& rows) {
  std::array<std::uint8_t, 64> mixed{};
  // Of the four rows that come at once, the first in every `stride` have the kind of the first.
  const auto take = [&](int exponent, std::int32_t y, std::int32_t z, std::int32_t stride) {
    const Rows4 of_rows = mixed_in_rows(rows, exponent, y, z);
    for (std::int32_t i = 0; i < 4; i += stride) {
      mixed[static_cast<std::size_t>(y + 2 * i + kCell * z)] |=
          static_cast<std::uint8_t>(of_rows[i]);
    }
  };
  for (std::int32_t z = 0; z < kCell; ++z) {
    take(0, 0, z, 1);
    take(0, 1, z, 1);
  }
  for (std::int32_t z = 0; z < kCell; z += 2) {
    take(1, 0, z, 2);
    take(1, 2, z, 2);
  }
  for (std::int32_t z = 0; z < kCell; z += 4) {
    take(2, 0, z, 4);
    take(2, 4, z, 4);
  }
  return mixed;
}

}  // namespace multitetra
