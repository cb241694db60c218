// One bit for each point of a cell, and neighbourhood operations on all of them at once.
//
// A plane is 64 bits: bit x + 8 y for the point (x, y) of one layer. A `BitGrid` has eight planes
// for each cell, and shifts planes across the cells' borders.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace multitetra {

using BitPlane = std::uint64_t;

// Returns the bits of a plane whose x lies in `x_bits` and whose y lies in `y_bits`.
[[nodiscard]] constexpr BitPlane plane_of(unsigned x_bits, unsigned y_bits) {
  BitPlane plane = 0;
  for (unsigned y = 0; y < 8; ++y) {
    if ((y_bits >> y & 1U) != 0) plane |= BitPlane{x_bits} << (8 * y);
  }
  return plane;
}

class BitGrid {
 public:
  // Clears the grid and sets its cells along each axis, which get a border of empty cells.
  void begin(std::int32_t cells) {
    const auto stride = static_cast<std::size_t>(cells + 2);
    strides_ = {1, stride, stride * stride};
    planes_.assign(stride * stride * stride, {});
  }
  // Returns the index of the cell (x, y, z), coordinates from 0.
  [[nodiscard]] std::size_t cell(std::int32_t x, std::int32_t y, std::int32_t z) const {
    return static_cast<std::size_t>(x + 1) + strides_[1] * static_cast<std::size_t>(y + 1) +
           strides_[2] * static_cast<std::size_t>(z + 1);
  }
  [[nodiscard]] BitPlane& plane(std::size_t cell, std::int32_t z) {
    return planes_[cell][static_cast<std::size_t>(z)];
  }
  [[nodiscard]] BitPlane plane(std::size_t cell, std::int32_t z) const {
    return planes_[cell][static_cast<std::size_t>(z)];
  }
  // Returns layer z, -8 <= z < 16.
  [[nodiscard]] BitPlane layer(std::size_t cell, std::int32_t z) const {
    if (z < 0) return planes_[cell - strides_[2]][static_cast<std::size_t>(z + 8)];
    if (z >= 8) return planes_[cell + strides_[2]][static_cast<std::size_t>(z - 8)];
    return planes_[cell][static_cast<std::size_t>(z)];
  }
  // The bits of layer z, and of the neighbours at a distance of `step` = 1, 2 or 4 along its axes.
  struct Around {
    BitPlane here = 0;
    BitPlane along_y = 0;   // Either neighbour along y.
    BitPlane along_x = 0;   // Either neighbour along x.
    BitPlane diagonal = 0;  // Any of the four diagonal neighbours.
  };
  [[nodiscard]] Around around(std::size_t cell, std::int32_t z, int step) const {
    const BitPlane here = layer(cell, z);
    const BitPlane before = layer(cell - 1, z);
    const BitPlane behind = layer(cell + 1, z);
    const auto along_y = [&](BitPlane plane, std::size_t at) {
      return plane << (8 * step) | plane >> (8 * step) |
             layer(at - strides_[1], z) >> (64 - 8 * step) |
             layer(at + strides_[1], z) << (64 - 8 * step);
    };
    const BitPlane here_y = along_y(here, cell);
    const auto along_x = [&](BitPlane plane, BitPlane low, BitPlane high) {
      const BitPlane lower = kLower[static_cast<std::size_t>(step)];
      const BitPlane upper = kUpper[static_cast<std::size_t>(step)];
      return (plane << step & ~lower) | (low >> (8 - step) & lower) | (plane >> step & upper) |
             (high << (8 - step) & ~upper);
    };
    return {.here = here,
            .along_y = here_y,
            .along_x = along_x(here, before, behind),
            .diagonal = along_x(here_y, along_y(before, cell - 1), along_y(behind, cell + 1))};
  }

 private:
  // The `step` lowest points of every row, and all but the `step` highest.
  static constexpr std::array<BitPlane, 5> kLower = {0, plane_of(0x01, 0xFF), plane_of(0x03, 0xFF),
                                                     0, plane_of(0x0F, 0xFF)};
  static constexpr std::array<BitPlane, 5> kUpper = {0, plane_of(0x7F, 0xFF), plane_of(0x3F, 0xFF),
                                                     0, plane_of(0x0F, 0xFF)};

  std::array<std::size_t, 3> strides_{};
  std::vector<std::array<BitPlane, 8>> planes_;
};

}  // namespace multitetra
