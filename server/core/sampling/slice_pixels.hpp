// The field on a plane, or on layers of planes, pixel by pixel.
//
//   const SliceRequest plane = in_indices(request, volume.info);
//   const std::int32_t spacing = slice_spacing(plane, volume.info);
//   slice_rows(volume, plane, spacing, 0, plane.height, values);
//
// A pixel depends only on the volume, its place and the spacing, so any thread can compute any row.
#pragma once

#include <cstdint>
#include <span>

#include "common/request/slice_request.hpp"
#include "server/core/spectrum/prepared_volume.hpp"

namespace multitetra {

// The approximate number of bricks that a slice of all samples may read: those of an axis-parallel
// plane of 5792 x 5792 samples, 1 GiB of 16-bit samples.
inline constexpr double kMaxSliceBricks = 131072;

// Returns about how many bricks the plane, or its layers, cross. Requires a plane in sample
// indices.
[[nodiscard]] double bricks_crossed(const SliceRequest& plane, const DatasetInfo& info);

// Returns the spacing, along each axis, of the samples that the slice uses: 1 or kSpectrumSpacing.
// kAuto selects the latter if pixels lie at least half as far apart, or if all samples would need
// more than kMaxSliceBricks bricks. Requires a plane in sample indices.
[[nodiscard]] std::int32_t slice_spacing(const SliceRequest& plane, const DatasetInfo& info);

// Computes `rows` rows of pixels of each layer from `first_row` on; NaN where there is no field.
// Requires a validated plane in sample indices, the spacing from slice_spacing(), and `values` of
// all pixels, of which others stay as they are. Rethrows exceptions from reading a brick.
void slice_rows(const PreparedVolume& volume, const SliceRequest& plane, std::int32_t spacing,
                std::uint32_t first_row, std::uint32_t rows, std::span<float> values);

}  // namespace multitetra
