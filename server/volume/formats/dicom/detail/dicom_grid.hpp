// The grid that the slices of a DICOM series lie on: theirs, where they are even and straight, or
// one that they are interpolated to.
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

// The positions of slices before they are interpolated.
struct SlicePlaces {
  std::vector<double>
      at;  // Along the normal, in steps of the grid from its first slice on; rising.
  // The offset of each slice's first sample on the grid, in samples.
  std::vector<std::array<double, 2>> shift;
  std::array<std::int64_t, 2> size{};  // Columns and rows of the slices.
};

struct DicomGrid {
  std::array<std::int64_t, 3> dims{};
  std::array<Vec3, 3> steps{};
  Vec3 origin{};
  std::optional<SlicePlaces> resampled = std::nullopt;  // None: slices are those of the grid.
};

// The grid of `stack`, which is sorted along the normal and has one size and orientation. Slices
// that are up to a tenth of a step off an even grid are taken to be on it, with a notice of the
// largest deviation. Others, and those of a tilted gantry, are interpolated when `resample` is set,
// with a notice; else they are refused. Throws VolumeFileError.
[[nodiscard]] DicomGrid dicom_grid(const std::filesystem::path& place,
                                   const std::vector<DicomImage>& stack, bool resample,
                                   std::vector<std::string>& notices);

// `slices`, floats with `components` numbers a sample, interpolated linearly to the grid; void
// (NaN) where a shifted slice does not reach.
[[nodiscard]] std::unique_ptr<StoredSlices> resampled_slices(std::unique_ptr<StoredSlices> slices,
                                                             const DicomGrid& grid,
                                                             std::int64_t components);

}  // namespace multitetra
