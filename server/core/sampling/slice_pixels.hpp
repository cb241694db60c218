// The field on a plane, pixel by pixel.
//
//   const SliceRequest plane = in_indices(request, volume.info);
//   const std::int32_t spacing = slice_spacing(plane, volume.info);
//   slice_rows(volume, plane, spacing, 0, plane.height, values);
//
// A pixel depends on the volume, its place and the spacing alone, so rows may be made on any
// threads.
#pragma once

#include <cstdint>
#include <span>

#include "common/request/slice_request.hpp"
#include "server/core/spectrum/prepared_volume.hpp"

namespace multitetra {

// About as many bricks of samples as a slice of all samples may read: those of a plane of 5792 x
// 5792 samples along the axes, 1 GiB of samples of 16 bits.
inline constexpr double kMostSliceBricks = 131072;

// About how many bricks of samples the plane crosses. Requires a plane in sample indices.
[[nodiscard]] double bricks_crossed(const SliceRequest& plane, const DatasetInfo& info);

// The distance, along each axis, of the samples that the slice is made of: 1, or
// kSpectrumSpacing. With kAuto the latter where pixels lie at least half as far apart, or where all
// samples would be more than kMostSliceBricks. Requires a plane in sample indices.
[[nodiscard]] std::int32_t slice_spacing(const SliceRequest& plane, const DatasetInfo& info);

// The pixels of `rows` rows from `first_row` on, row by row; NaN where there is no field. Requires
// a validated plane in sample indices, a spacing that slice_spacing() gives for it, and as many
// values as pixels. Throws what reading a brick throws.
void slice_rows(const PreparedVolume& volume, const SliceRequest& plane, std::int32_t spacing,
                std::uint32_t first_row, std::uint32_t rows, std::span<float> values);

}  // namespace multitetra
