#include "common/request/threshold_shrinking.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/vec3.hpp"

namespace multitetra {
namespace {

using Counts = std::array<std::int32_t, 3>;

Counts blocks_of(const Counts& dims, const Counts& side) {
  Counts blocks;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    blocks[axis] = (dims[axis] - 1) / side[axis] + 1;
  }
  return blocks;
}

// Returns the number of samples of a block along each axis.
Counts block_side(const ThresholdSamples& image, std::size_t limit) {
  Counts side = {1, 1, 1};
  for (;;) {
    const Counts blocks = blocks_of(image.dims, side);
    const double count = static_cast<double>(blocks[0]) * blocks[1] * blocks[2];
    if (count <= static_cast<double>(limit)) return side;
    std::size_t shortest = 3;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double extent = side[axis] * length(image.index_to_world.columns[axis]);
      if (blocks[axis] > 1 && extent < least) {
        least = extent;
        shortest = axis;
      }
    }
    if (shortest == 3) return side;  // One block, or NaN lengths.
    ++side[shortest];
  }
}

// Maps block indices to world coordinates; a block's index is its center.
Affine block_map(const ThresholdSamples& image, const Counts& side) {
  Affine map = image.index_to_world;
  Vec3 first_middle = {};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    first_middle[axis] = 0.5 * (side[axis] - 1);
    for (double& number : map.columns[axis]) number *= side[axis];
  }
  map.translation = image.index_to_world(first_middle);
  return map;
}

float block_threshold(const ThresholdSamples& image, const Counts& low, const Counts& side,
                      float elsewhere) {
  float least = std::numeric_limits<float>::infinity();
  bool is_whole = true;
  bool says_something = false;
  for (std::int32_t z = low[2]; z < low[2] + side[2]; ++z) {
    for (std::int32_t y = low[1]; y < low[1] + side[1]; ++y) {
      for (std::int32_t x = low[0]; x < low[0] + side[0]; ++x) {
        if (x >= image.dims[0] || y >= image.dims[1] || z >= image.dims[2]) {
          is_whole = false;
          continue;
        }
        const std::size_t at =
            static_cast<std::size_t>(x) +
            static_cast<std::size_t>(image.dims[0]) *
                (static_cast<std::size_t>(y) +
                 static_cast<std::size_t>(image.dims[1]) * static_cast<std::size_t>(z));
        const float threshold = image.thresholds[at];
        if (std::isnan(threshold)) {
          is_whole = false;
        } else {
          says_something = true;
          least = std::min(least, threshold);
        }
      }
    }
  }
  if (!says_something) return std::numeric_limits<float>::quiet_NaN();
  return is_whole ? least : std::min(least, elsewhere);
}

// Returns the largest float that is at most `value`.
float float_below(double value) {
  if (value >= static_cast<double>(std::numeric_limits<float>::max())) {
    return std::numeric_limits<float>::max();
  }
  const auto nearest = static_cast<float>(value);
  return static_cast<double>(nearest) <= value ? nearest : std::nextafter(nearest, -1.0F);
}

}  // namespace

ThresholdGrid shrunk(const ThresholdSamples& image, double elsewhere, std::size_t limit) {
  const Counts side = block_side(image, limit);
  const Counts blocks = blocks_of(image.dims, side);
  ThresholdGrid grid{.dims = blocks, .index_to_world = block_map(image, side)};
  const float least_elsewhere = float_below(elsewhere);
  for (std::int32_t z = 0; z < blocks[2]; ++z) {
    for (std::int32_t y = 0; y < blocks[1]; ++y) {
      for (std::int32_t x = 0; x < blocks[0]; ++x) {
        grid.thresholds.push_back(
            block_threshold(image, {x * side[0], y * side[1], z * side[2]}, side, least_elsewhere));
      }
    }
  }
  return grid;
}

}  // namespace multitetra
