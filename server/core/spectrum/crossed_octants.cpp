#include "server/core/spectrum/crossed_octants.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>

#include "server/core/spectrum/spectrum_layout.hpp"

namespace multitetra {
namespace {

// A range along one axis.
struct Span {
  std::int32_t first = 0;
  std::int32_t last = 0;
};

// The sides of the isovalue on which values were found.
struct Sides {
  bool above = false;
  bool not_above = false;

  [[nodiscard]] bool are_both() const { return above && not_above; }
};

// Returns the cells of a cube along an axis, clipped to the `count` cells of the data from `low`.
Span cells_of(std::int32_t position, std::int32_t cells, std::int32_t low, std::int32_t count) {
  return {std::max(position * cells, low), std::min((position + 1) * cells, low + count) - 1};
}

template <typename Sample>
void scan_cells(const PreparedVolume& volume, const OctreeCube& cube, double isovalue,
                Sides& sides) {
  const LevelExtent cells = cell_extent(volume.info);
  const std::span<const std::byte> ranges = volume.ranges.bytes();
  const std::int32_t side = cube.side() >> kSpectrumExponent;
  const Span x = cells_of(cube.x, side, cells.low.x, cells.extent.x);
  const Span y = cells_of(cube.y, side, cells.low.y, cells.extent.y);
  const Span z = cells_of(cube.z, side, cells.low.z, cells.extent.z);
  for (std::int32_t k = z.first; k <= z.last; ++k) {
    for (std::int32_t j = y.first; j <= y.last; ++j) {
      for (std::int32_t i = x.first; i <= x.last; ++i) {
        std::array<Sample, 2> range;
        std::memcpy(range.data(), ranges.data() + sizeof(range) * cells.index({i, j, k}),
                    sizeof(range));
        const auto low = static_cast<double>(range[0]);
        const auto high = static_cast<double>(range[1]);
        if (low > high) continue;  // All samples are void.
        sides.above |= high > isovalue;
        sides.not_above |= !(low > isovalue);
        if (sides.are_both()) return;
      }
    }
  }
}

// Returns whether the closed cube contains points beyond the data.
bool reaches_outside(const DatasetInfo& info, const OctreeCube& cube) {
  const GridPoint first = first_sample(info);
  const GridPoint last = last_sample(info);
  const auto is_beyond = [side = cube.side()](std::int32_t position, std::int32_t low,
                                              std::int32_t high) {
    return position * side < low || (position + 1) * side > high;
  };
  return is_beyond(cube.x, first.x, last.x) || is_beyond(cube.y, first.y, last.y) ||
         is_beyond(cube.z, first.z, last.z);
}

}  // namespace

bool is_crossed(const PreparedVolume& volume, const OctreeCube& cube, double isovalue) {
  Sides sides;
  if (volume.info.outside && reaches_outside(volume.info, cube)) {
    const auto outside = static_cast<double>(outside_value(volume.info));
    sides.above = outside > isovalue;
    sides.not_above = !sides.above;
  }
  visit_type(volume.info.type, [&]<typename Sample>(const Sample*) {
    scan_cells<Sample>(volume, cube, isovalue, sides);
  });
  return sides.are_both();
}

std::uint32_t crossed_octants(const PreparedVolume& volume, const OctreeCube& cube,
                              double isovalue) {
  if (cube.exponent <= kSpectrumExponent) return 0xFF;
  std::uint32_t crossed = 0;
  for (int i = 0; i < 8; ++i) {
    crossed |= static_cast<std::uint32_t>(is_crossed(volume, cube.child(i), isovalue)) << i;
  }
  return crossed;
}

}  // namespace multitetra
