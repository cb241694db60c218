#include "server/extraction/sampled_slice.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/base/in_parallel.hpp"
#include "server/core/sampling/sample_reader.hpp"

namespace multitetra {

Result<SampledSlice> sampled_slice(const PreparedVolume& volume, const SliceRequest& slice,
                                   std::stop_token stop) {
  constexpr std::uint32_t kRows = 16;  // Rows of a task, as many as a brick has.
  const SliceRequest plane = in_indices(slice, volume.info);
  SampledSlice sampled{.spacing = slice_spacing(plane, volume.info), .values = {}};
  const double bricks = bricks_crossed(plane, volume.info);
  if (sampled.spacing == 1 && bricks > kMaxSliceBricks && has_coarse_samples(volume.info)) {
    return fail(ErrorCode::kLimitExceeded,
                "The slice crosses about " + std::to_string(std::llround(bricks)) +
                    " bricks of samples; at most " + std::to_string(std::llround(kMaxSliceBricks)) +
                    " are read. Request a smaller part, or the detail auto or coarse.");
  }
  sampled.values.resize(plane.pixels());
  in_parallel((plane.height + kRows - 1) / kRows,
              [&](std::size_t piece) {
                const auto first = static_cast<std::uint32_t>(piece) * kRows;
                const std::uint32_t rows = std::min(kRows, plane.height - first);
                slice_rows(volume, plane, sampled.spacing, first, rows, sampled.values);
              },
              stop);
  if (volume.check) volume.check();
  return sampled;
}

}  // namespace multitetra
