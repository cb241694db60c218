// The grid of a DICOM series: that of its slices if they are evenly spaced and straight, else one
// to which they are interpolated.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/volume/formats/dicom/detail/dicom_image.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Positions of slices before interpolation.
struct SlicePlaces {
  std::vector<double> at;  // Along the normal, in grid steps from the first slice; increasing.
  // Offset of each slice's first sample on the grid, in samples.
  std::vector<std::array<double, 2>> shift;
  std::array<std::int64_t, 2> size{};  // Columns and rows of the slices.
};

struct DicomGrid {
  std::array<std::int64_t, 3> dims{};
  std::array<Vec3, 3> steps{};
  Vec3 origin{};
  std::optional<SlicePlaces> resampled = std::nullopt;  // Absent if slices are on the grid.
};

// Returns the grid of `stack`, which must be sorted along the normal and have one size and
// orientation. Slices within a tenth of a step of an even grid are taken to be on it, with a notice
// of the largest deviation. Others, and those of a tilted gantry, are interpolated with a notice if
// `resample` is set, else refused. Throws VolumeFileError.
[[nodiscard]] DicomGrid dicom_grid(const std::filesystem::path& place,
                                   const std::vector<DicomImage>& stack, bool resample,
                                   std::vector<std::string>& notices);

// Interpolates `slices`, floats with `components` numbers per sample, linearly to the grid; void
// (NaN) where a shifted slice does not reach.
[[nodiscard]] std::unique_ptr<StoredSlices> resampled_slices(std::unique_ptr<StoredSlices> slices,
                                                             const DicomGrid& grid,
                                                             std::int64_t components);

}  // namespace multitetra
