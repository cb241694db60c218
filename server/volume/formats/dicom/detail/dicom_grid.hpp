// The grid of a DICOM series: that of its slices if they are evenly spaced and straight, else one
// to which they are interpolated.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "server/volume/formats/dicom/detail/dicom_image.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

struct DicomGrid {
  std::array<Vec3, 3> steps{};
  Vec3 origin{};
  std::optional<SlicePlaces> resampled = std::nullopt;  // Absent if slices are on the grid.
};

// Returns the grid of `stack`, which must be sorted along the normal and have one size and
// orientation. Slices within a tenth of a step of an even grid are taken to be on it, with a notice
// of the largest deviation, and all slices if choice.given has a spacing. Others, and those of a
// tilted gantry, are resampled with a notice if choice.resample is set, else refused. Throws
// VolumeFileError.
[[nodiscard]] DicomGrid dicom_grid(const std::filesystem::path& place,
                                   const std::vector<DicomImage>& stack, const VolumeChoice& choice,
                                   std::vector<std::string>& notices);

}  // namespace multitetra
