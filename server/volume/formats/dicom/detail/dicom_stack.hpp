// The slices of a volume among the images of a DICOM series.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "server/volume/formats/dicom/detail/dicom_image.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Returns one image per position, sorted by position: those of choice.time if there are several
// times, whose number it sets. Images without positions are placed in the order of their numbers.
// Drops localizers and images unlike the others, with a notice, and adds those about the files and
// their places. Requires images. Throws VolumeFileError.
[[nodiscard]] std::vector<DicomImage> dicom_stack(const std::filesystem::path& place,
                                                  std::vector<DicomImage> images,
                                                  const VolumeChoice& choice,
                                                  std::vector<std::string>& notices,
                                                  SourceTimes& times);

}  // namespace multitetra
