#include "server/core/thresholds/detail/threshold_pyramid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace multitetra {
namespace {

constexpr float kNoThreshold = std::numeric_limits<float>::infinity();

double world(float threshold, double unit) {
  return std::min(static_cast<double>(threshold) * unit, std::numeric_limits<double>::max());
}

}  // namespace

ThresholdPyramid::ThresholdPyramid(const ThresholdGrid& grid, const Affine& to_samples, double unit)
    : to_samples_(to_samples), unit_(unit), thresholds_(grid.thresholds) {
  Level finest{.dims = grid.dims, .cells = {}};
  for (const float threshold : grid.thresholds) {
    const bool has_no_threshold = std::isnan(threshold);
    finest.cells.push_back(
        {.least = has_no_threshold ? kNoThreshold : threshold, .has_gap = has_no_threshold});
  }
  levels_.push_back(std::move(finest));
  while (levels_.back().cells.size() > 1) {
    const Level& finer = levels_.back();
    Level level;
    for (std::size_t axis = 0; axis < 3; ++axis) level.dims[axis] = (finer.dims[axis] + 1) / 2;
    level.cells.assign(
        static_cast<std::size_t>(std::int64_t{level.dims[0]} * level.dims[1] * level.dims[2]),
        {.least = kNoThreshold, .has_gap = false});
    std::size_t from = 0;
    for (std::int32_t z = 0; z < finer.dims[2]; ++z) {
      for (std::int32_t y = 0; y < finer.dims[1]; ++y) {
        for (std::int32_t x = 0; x < finer.dims[0]; ++x, ++from) {
          const std::int64_t to =
              (std::int64_t{z / 2} * level.dims[1] + y / 2) * level.dims[0] + x / 2;
          Cell& cell = level.cells[static_cast<std::size_t>(to)];
          cell.least = std::min(cell.least, finer.cells[from].least);
          cell.has_gap = cell.has_gap || finer.cells[from].has_gap;
        }
      }
    }
    levels_.push_back(std::move(level));
  }
}

ThresholdPyramid::Range ThresholdPyramid::range_of(const Box& box) const {
  const Box image = image_of(to_samples_, box);
  const Level& finest = levels_.front();
  Range range;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double last = finest.dims[axis] - 1;
    const double low = std::max(std::ceil(image.low[axis] - 0.5), 0.0);
    const double high = std::min(std::floor(image.high[axis] + 0.5), last);
    range.leaves_grid |= image.low[axis] < -0.5 || image.high[axis] > last + 0.5;
    range.is_empty |= low > high;
    if (low > high) continue;  // The values may not fit into integers.
    range.first[axis] = static_cast<std::int32_t>(low);
    range.last[axis] = static_cast<std::int32_t>(high);
  }
  return range;
}

ThresholdBound ThresholdPyramid::least_in(const Box& box) const {
  const Range range = range_of(box);
  Cell bound{.least = kNoThreshold, .has_gap = range.leaves_grid || range.is_empty};
  if (!range.is_empty) {
    // The finest level on which the range spans at most two cells along every axis.
    int level = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      while ((range.last[axis] >> level) - (range.first[axis] >> level) > 1) ++level;
    }
    for (std::int32_t z = range.first[2] >> level; z <= range.last[2] >> level; ++z) {
      for (std::int32_t y = range.first[1] >> level; y <= range.last[1] >> level; ++y) {
        for (std::int32_t x = range.first[0] >> level; x <= range.last[0] >> level; ++x) {
          add(level, {x, y, z}, range, bound);
        }
      }
    }
  }
  if (bound.least == kNoThreshold) return {.has_gap = bound.has_gap};
  return {.least = world(bound.least, unit_), .has_gap = bound.has_gap};
}

void ThresholdPyramid::add(int level, const std::array<std::int32_t, 3>& cell, const Range& range,
                           Cell& bound) const {
  const Cell& here = levels_[static_cast<std::size_t>(level)].at(cell[0], cell[1], cell[2]);
  if (here.least >= bound.least && (bound.has_gap || !here.has_gap)) return;
  bool is_inside = true;
  std::array<std::int32_t, 3> first;  // Cells of the next finer level, clipped to the range.
  std::array<std::int32_t, 3> last;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int32_t low = cell[axis] << level;
    const std::int32_t high =
        std::min(low + (std::int32_t{1} << level), levels_.front().dims[axis]) - 1;
    is_inside = is_inside && range.first[axis] <= low && high <= range.last[axis];
    if (level == 0) continue;
    first[axis] = std::max(low, range.first[axis]) >> (level - 1);
    last[axis] = std::min(high, range.last[axis]) >> (level - 1);
  }
  if (is_inside) {
    bound.least = std::min(bound.least, here.least);
    bound.has_gap = bound.has_gap || here.has_gap;
    return;
  }
  for (std::int32_t z = first[2]; z <= last[2]; ++z) {
    for (std::int32_t y = first[1]; y <= last[1]; ++y) {
      for (std::int32_t x = first[0]; x <= last[0]; ++x) add(level - 1, {x, y, z}, range, bound);
    }
  }
}

double ThresholdPyramid::largest_in(const Box& box) const {
  const Range range = range_of(box);
  if (range.is_empty) return 0;
  const auto& dims = levels_.front().dims;
  float largest = 0;
  for (std::int32_t z = range.first[2]; z <= range.last[2]; ++z) {
    for (std::int32_t y = range.first[1]; y <= range.last[1]; ++y) {
      for (std::int32_t x = range.first[0]; x <= range.last[0]; ++x) {
        // std::max ignores NaN as second argument.
        largest = std::max(
            largest,
            thresholds_[static_cast<std::size_t>((std::int64_t{z} * dims[1] + y) * dims[0] + x)]);
      }
    }
  }
  return world(largest, unit_);
}

}  // namespace multitetra
