// What a prepared dataset offers to queries: the volume in parts that can be read one at a time,
// and its errors for every isovalue.
#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <span>

#include "common/dataset_info.hpp"
#include "server/core/error_spectrum.hpp"
#include "server/core/level_extent.hpp"
#include "server/core/sample_bricks.hpp"

namespace multitetra {

// A cell is a cube of kSpectrumSpacing grid steps, at multiples of it. The closed cells that hold a
// sample of the data:
[[nodiscard]] constexpr CoarseExtent cell_extent(const DatasetInfo& info) {
  const std::int32_t first = std::max(0, info.margin - 1) / kSpectrumSpacing;
  CoarseExtent cells{.origin = {first, first, first}, .dims = {}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    cells.dims[axis] = (info.margin + info.dims[axis] - 1) / kSpectrumSpacing - first + 1;
  }
  return cells;
}

// The value beyond the data, NaN for void.
[[nodiscard]] inline float outside_value(const DatasetInfo& info) {
  return info.outside ? static_cast<float>(*info.outside) : std::numeric_limits<float>::quiet_NaN();
}

// Immutable. The spans live as long as `owner`.
struct PreparedVolume {
  DatasetInfo info;
  std::shared_ptr<const BrickSource> samples;  // BrickLayout(info.dims), x fastest in a brick.
  std::span<const std::byte> coarse;  // The samples of coarse_extent(info, kSpectrumSpacing).
  std::span<const std::byte> ranges;  // Of every closed cell of cell_extent(info): the least and
                                      // the largest sample in it; void ones do not count, and where
                                      // all are void the least is larger than the largest.
  ErrorSpectrum spectrum;
  std::shared_ptr<const void> owner;
};

// Calls `visitor` with a null pointer to the sample type: one dispatch for a whole pass.
template <typename Visitor>
decltype(auto) visit_type(SampleType type, Visitor&& visitor) {
  switch (type) {
    case SampleType::kU8:
      return visitor(static_cast<const std::uint8_t*>(nullptr));
    case SampleType::kI8:
      return visitor(static_cast<const std::int8_t*>(nullptr));
    case SampleType::kU16:
      return visitor(static_cast<const std::uint16_t*>(nullptr));
    case SampleType::kI16:
      return visitor(static_cast<const std::int16_t*>(nullptr));
    case SampleType::kF32:
      break;
  }
  return visitor(static_cast<const float*>(nullptr));
}

}  // namespace multitetra
