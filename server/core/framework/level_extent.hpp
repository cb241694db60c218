// The array extent of the dividing points of one spacing that can have an error.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "common/dataset/dataset_info.hpp"
#include "server/core/framework/grid.hpp"

namespace multitetra {

[[nodiscard]] constexpr int exponent_of(std::int32_t spacing) {
  return std::countr_zero(static_cast<std::uint32_t>(spacing));
}

// A box of points in units of 2^exponent grid steps, x fastest.
struct LevelExtent {
  int exponent = 0;
  GridPoint low;     // In units.
  GridPoint extent;  // Points along each axis.

  [[nodiscard]] constexpr bool contains(GridPoint unit_point) const {
    const GridPoint at = unit_point - low;
    return at.x >= 0 && at.y >= 0 && at.z >= 0 && at.x < extent.x && at.y < extent.y &&
           at.z < extent.z;
  }
  [[nodiscard]] constexpr std::size_t index(GridPoint unit_point) const {
    const GridPoint at = unit_point - low;
    return static_cast<std::size_t>(at.x) +
           static_cast<std::size_t>(extent.x) *
               (static_cast<std::size_t>(at.y) +
                static_cast<std::size_t>(extent.y) * static_cast<std::size_t>(at.z));
  }
  [[nodiscard]] constexpr std::size_t size() const {
    return static_cast<std::size_t>(extent.x) * static_cast<std::size_t>(extent.y) *
           static_cast<std::size_t>(extent.z);
  }
  // Requires a point whose spacing is at least 2^exponent.
  [[nodiscard]] constexpr GridPoint unit_point(GridPoint p) const {
    return {p.x >> exponent, p.y >> exponent, p.z >> exponent};
  }
};

// Returns the extent of the points of spacing 2^exponent: the box of data from `first` to `last`,
// enlarged by three units. Points farther away have error 0, since the diamonds of all their
// descendants lie within three units of them.
[[nodiscard]] constexpr LevelExtent level_extent(const Grid& grid, GridPoint first, GridPoint last,
                                                 int exponent) {
  const std::int32_t end = grid.side() >> exponent;
  const auto low = [&](std::int32_t v) { return std::max(0, (v >> exponent) - 3); };
  const auto high = [&](std::int32_t v) { return std::min(end, -(-v >> exponent) + 3); };
  LevelExtent level{
      .exponent = exponent, .low = {low(first.x), low(first.y), low(first.z)}, .extent = {}};
  level.extent =
      GridPoint{high(last.x), high(last.y), high(last.z)} - level.low + GridPoint{1, 1, 1};
  return level;
}

// Return a dataset's grid and the position of its data in it.
[[nodiscard]] inline Grid grid_of(const DatasetInfo& info) { return Grid(info.grid_exponent); }
[[nodiscard]] constexpr GridPoint first_sample(const DatasetInfo& info) {
  return {info.margin, info.margin, info.margin};
}
[[nodiscard]] constexpr GridPoint last_sample(const DatasetInfo& info) {
  return first_sample(info) + GridPoint{info.dims[0] - 1, info.dims[1] - 1, info.dims[2] - 1};
}

}  // namespace multitetra
