// Coarsens a grid of thresholds until it fits into a request.
#pragma once

#include <cstddef>
#include <span>

#include "common/request/local_thresholds.hpp"

namespace multitetra {

// An image of thresholds of any size.
struct ThresholdSamples {
  std::array<std::int32_t, 3> dims = {};  // Each at least 1.
  Affine index_to_world;
  // x fastest, as many as `dims` requires; NaN: no threshold.
  std::span<const float> thresholds;
};

// Merges blocks of neighbouring samples, of similar length along all axes, until at most `limit`
// remain. Images that fit are unchanged. A block gets the least threshold of its samples, and at
// most `elsewhere` if a sample has none or lies beyond the image, so no place allows more than the
// image does. A block without thresholds gets none.
[[nodiscard]] ThresholdGrid shrunk(const ThresholdSamples& image, double elsewhere,
                                   std::size_t limit = kMaxGridThresholds);

}  // namespace multitetra
