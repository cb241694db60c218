// Which dividing points of a cell have values on both sides of the isovalue in their diamond, found
// for all of them at once with one bit per sample.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "server/core/row_kinds.hpp"

namespace multitetra {

// Of eight points in a row, those of spacing 2^[i] with an even and with an odd coordinate.
inline constexpr unsigned kPositions[3][2] = {{0x55, 0xAA}, {0x11, 0x44}, {0x01, 0x10}};

// The signs of the rows in and around a cell of 8 x 8 x 8 samples. A row is 24 bits, from eight
// samples before the cell to eight behind it; there is one for every y and z from four before the
// cell on, which is farther than diamonds of spacing 4 reach. Rows with even and with odd y are
// kept apart, so that four rows that are two apart lie side by side.
class SignRows {
 public:
  static constexpr std::int32_t kFirst = -4;  // y and z as seen from the cell's first sample.
  static constexpr std::int32_t kEnd = 12;

  void set(std::int32_t y, std::int32_t z, std::uint32_t above, std::uint32_t below) {
    above_[index(y, z)] = above;
    below_[index(y, z)] = below;
  }
  // Rows y, y + 2, y + 4, ... follow each other.
  [[nodiscard]] const std::uint32_t* above(std::int32_t y, std::int32_t z) const {
    return &above_[index(y, z)];
  }
  [[nodiscard]] const std::uint32_t* below(std::int32_t y, std::int32_t z) const {
    return &below_[index(y, z)];
  }

 private:
  [[nodiscard]] static std::size_t index(std::int32_t y, std::int32_t z) {
    const std::int32_t from = y - kFirst;
    return static_cast<std::size_t>(16 * (z - kFirst) + 8 * (from & 1) + (from >> 1));
  }

  using Rows = std::array<std::uint32_t, 256>;
  Rows above_;
  Rows below_;
};

// Element y + 8 z, bit x: whether the diamond of the cell's point (x, y, z) has values of both
// signs. For points of spacing 1, 2 and 4; the bit of the one that is coarser is not set.
[[nodiscard]] std::array<std::uint8_t, 64> mixed_diamonds(const SignRows& rows);

}  // namespace multitetra
