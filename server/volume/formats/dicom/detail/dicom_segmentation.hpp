// DICOM SEG as a label map: samples are the numbers of segments, 0 outside of them.
#pragma once

#include <filesystem>
#include <vector>

#include "server/volume/formats/dicom/detail/dicom_image.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Returns the volume of a segmentation: all frames of one file. Where segments overlap, samples
// have several components, each with segments that do not: the layers of contents.labels. Slices
// without a frame are empty. Fractional segments end at half of their largest sample. Throws
// VolumeFileError unless all frames are on one grid.
[[nodiscard]] StoredVolume open_dicom_segmentation(const std::filesystem::path& place,
                                                   std::vector<DicomImage> frames,
                                                   const VolumeChoice& choice);

}  // namespace multitetra
