// The least threshold of a coarse grid over a box: a pyramid of minima over its samples.
//
// A sample applies to its voxel, half a step around it, borders included. The result for a box is
// the minimum over all voxels touched by its image in the grid's own indices, or by the smallest
// box around that. Monotone (threshold_bound.hpp): the image and the voxel range of an inner box
// lie in those of the outer one.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/request/local_thresholds.hpp"
#include "server/core/framework/box.hpp"
#include "server/core/thresholds/detail/threshold_bound.hpp"

namespace multitetra {

class ThresholdPyramid {
 public:
  // `to_samples` maps grid coordinates to indices of the thresholds' own samples; `unit` is the
  // world length of the thresholds' unit.
  ThresholdPyramid(const ThresholdGrid& grid, const Affine& to_samples, double unit);

  [[nodiscard]] ThresholdBound least_in(const Box& box) const;

  // Returns an upper bound of least_in for any box within this one; 0 without a threshold.
  [[nodiscard]] double largest_in(const Box& box) const;

 private:
  struct Cell {
    float least = 0;  // Infinite without a threshold.
    bool has_gap = false;
  };
  // Level l holds the minima of blocks of 2^l samples a side; the last has one cell.
  struct Level {
    std::array<std::int32_t, 3> dims = {};
    std::vector<Cell> cells;
    [[nodiscard]] const Cell& at(std::int32_t x, std::int32_t y, std::int32_t z) const {
      return cells[static_cast<std::size_t>((std::int64_t{z} * dims[1] + y) * dims[0] + x)];
    }
  };
  // The samples from `first` to `last` on every axis.
  struct Range {
    std::array<std::int32_t, 3> first = {};
    std::array<std::int32_t, 3> last = {};
    bool is_empty = false;
    bool leaves_grid = false;  // The box extends beyond the grid.
  };

  [[nodiscard]] Range range_of(const Box& box) const;
  void add(int level, const std::array<std::int32_t, 3>& cell, const Range& range,
           Cell& bound) const;

  Affine to_samples_;
  double unit_;
  // NaN means no threshold.
  std::vector<float> thresholds_;
  std::vector<Level> levels_;
};

}  // namespace multitetra
