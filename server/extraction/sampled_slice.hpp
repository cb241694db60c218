// The field on a plane, computed on all threads.
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "common/base/result.hpp"
#include "server/core/sampling/slice_pixels.hpp"

namespace multitetra {

struct SampledSlice {
  std::int32_t spacing = 1;   // The spacing of the samples used: 1 or kSpectrumSpacing.
  std::vector<float> values;  // Layer by layer and row by row; NaN where there is no field.
};

// Requires a validated slice. Fails with kLimitExceeded if all samples are requested and need more
// than kMaxSliceBricks bricks. Throws Cancelled soon after `stop` is triggered, and
// DatasetFileError if the dataset is damaged.
[[nodiscard]] Result<SampledSlice> sampled_slice(const PreparedVolume& volume,
                                                 const SliceRequest& slice, std::stop_token stop);

}  // namespace multitetra
