// The query interface of a prepared dataset: the volume in parts that are read independently, and
// its errors for every isovalue.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <limits>
#include <memory>
#include <span>

#include "common/dataset/dataset_info.hpp"
#include "server/core/framework/level_extent.hpp"
#include "server/core/spectrum/error_spectrum.hpp"
#include "server/core/spectrum/sample_bricks.hpp"

namespace multitetra {

// Returns the extent of the samples at multiples of kSpectrumSpacing in the grid; may be empty.
[[nodiscard]] constexpr LevelExtent coarse_extent(const DatasetInfo& info) {
  const GridPoint last = last_sample(info);
  const std::int32_t first = (info.margin + kSpectrumSpacing - 1) >> kSpectrumExponent;
  const auto count = [first](std::int32_t v) {
    return std::max(0, (v >> kSpectrumExponent) - first + 1);
  };
  return {.exponent = kSpectrumExponent,
          .low = {first, first, first},
          .extent = {count(last.x), count(last.y), count(last.z)}};
}

// Returns the extent of the closed cells that contain a sample. A cell is a cube of
// kSpectrumSpacing grid steps, at multiples of it; its unit point is its lowest corner.
[[nodiscard]] constexpr LevelExtent cell_extent(const DatasetInfo& info) {
  const GridPoint last = last_sample(info);
  const std::int32_t first = std::max(0, info.margin - 1) >> kSpectrumExponent;
  const auto count = [first](std::int32_t v) { return (v >> kSpectrumExponent) - first + 1; };
  return {.exponent = kSpectrumExponent,
          .low = {first, first, first},
          .extent = {count(last.x), count(last.y), count(last.z)}};
}

// Returns the value beyond the data; NaN for void.
[[nodiscard]] inline float outside_value(const DatasetInfo& info) {
  return info.outside ? static_cast<float>(*info.outside) : std::numeric_limits<float>::quiet_NaN();
}

// Immutable. The spans are valid while `owner` lives, and unchanged as long as check() returns.
struct PreparedVolume {
  DatasetInfo info;
  std::shared_ptr<const BrickSource> samples;  // BrickLayout(info.dims), x fastest within a brick.
  LazyBytes coarse;                            // The samples of coarse_extent(info).
  // The least and the largest sample of every closed cell of cell_extent(info), ignoring void
  // samples; the least is larger than the largest if all are void.
  LazyBytes ranges;
  ErrorSpectrum spectrum;
  std::shared_ptr<const void> owner;
  // Throws if the volume's file was removed or changed meanwhile. Empty for volumes in memory.
  std::function<void()> check = {};
};

}  // namespace multitetra
