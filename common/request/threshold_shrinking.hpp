// A grid of thresholds made coarser until a request may carry it.
#pragma once

#include <cstddef>
#include <span>

#include "common/request/local_thresholds.hpp"

namespace multitetra {

// An image of thresholds of any size.
struct ThresholdSamples {
  std::array<std::int32_t, 3> dims = {};  // Each at least 1.
  Affine index_to_world;
  // x fastest, as many as the dims say; NaN: no threshold.
  std::span<const float> thresholds;
};

// Joins blocks of neighbouring samples, about as long on all axes, until at most `limit` are left;
// an image that fits is unchanged. A block has the least threshold of its samples, and at most
// `elsewhere` where one of them has none or is missing at the image's end: no place allows more
// than the image does. A block without any threshold has none.
[[nodiscard]] ThresholdGrid shrunk(const ThresholdSamples& image, double elsewhere,
                                   std::size_t limit = kMaxGridThresholds);

}  // namespace multitetra
