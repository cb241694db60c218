// The dividing points of a stored error spectrum, and their bricks.
#pragma once

#include <cstddef>
#include <vector>

#include "server/core/framework/level_extent.hpp"
#include "server/core/spectrum/sample_bricks.hpp"

namespace multitetra {

// Points of at least this spacing have stored errors; others are computed from the samples.
inline constexpr int kSpectrumExponent = 3;
inline constexpr std::int32_t kSpectrumSpacing = 1 << kSpectrumExponent;
// Grid steps around a cell of that spacing within which values affect the errors in it.
inline constexpr std::int32_t kSpectrumReach = 7;

// The bricks of all levels, from spacing kSpectrumSpacing on; those of one level are contiguous. A
// brick is a cube of 8 x 8 x 8 points of one level. The places of points that belong to coarser
// levels are included and stay empty.
class SpectrumLayout {
 public:
  static constexpr std::int32_t kSide = 8;
  static constexpr std::size_t kPoints = 512;

  explicit SpectrumLayout(const DatasetInfo& info) {
    for (int exponent = kSpectrumExponent; exponent < info.grid_exponent; ++exponent) {
      const LevelExtent extent =
          level_extent(grid_of(info), first_sample(info), last_sample(info), exponent);
      const BrickLayout bricks({extent.extent.x, extent.extent.y, extent.extent.z}, kSide);
      levels_.push_back({extent, bricks, size_});
      size_ += bricks.size();
    }
  }

  struct Level {
    LevelExtent extent;
    BrickLayout bricks;
    std::size_t first_brick;
  };
  struct Place {
    std::size_t brick;
    std::size_t point;  // Within the brick, x fastest.
  };

  [[nodiscard]] std::size_t size() const { return size_; }  // Number of bricks.
  // Levels of spacing 2^(kSpectrumExponent + i); none in grids of fewer than 16 steps.
  [[nodiscard]] const std::vector<Level>& levels() const { return levels_; }
  [[nodiscard]] const Level& level(int exponent) const {
    return levels_[static_cast<std::size_t>(exponent - kSpectrumExponent)];
  }
  // Requires level.extent.contains(unit_point).
  [[nodiscard]] static Place place(const Level& level, GridPoint unit_point) {
    const GridPoint at = unit_point - level.extent.low;
    const auto within = [](std::int32_t v) { return static_cast<std::size_t>(v % kSide); };
    return {level.first_brick + level.bricks.index({at.x / kSide, at.y / kSide, at.z / kSide}),
            within(at.x) + kSide * (within(at.y) + kSide * within(at.z))};
  }

 private:
  std::vector<Level> levels_;
  std::size_t size_ = 0;
};

}  // namespace multitetra
