// DICOM images through GDCM: the slices of a series in a folder, one file with one or many frames;
// packed as GDCM has it.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Whether a file that begins so is DICOM. 132 bytes are enough.
[[nodiscard]] bool is_dicom(std::string_view beginning);

// The DICOM files below a folder, sorted by name; empty when there are none. Hidden files and
// DICOMDIR are left out. Throws VolumeFileError for a .dcm file that is none, and for one whose
// name differs from that of a DICOM file in its digits alone.
[[nodiscard]] std::vector<std::filesystem::path> dicom_files(const std::filesystem::path& folder);

// The volume that the files of one series make up. Frames and slices are sorted by position; world
// coordinates are LPS in mm; slopes and intercepts are those of each frame. Of several series
// choice.series names one; of several images at each position choice.time chooses one. Localizers
// and images of another shape are left out with a notice. Slices that are missing, not evenly
// spaced (dicom_grid.hpp) or of a tilted gantry are interpolated with choice.resample. Throws
// VolumeFileError, also where a file is cut off. `place` is the source's name.
[[nodiscard]] StoredVolume open_dicom(const std::filesystem::path& place,
                                      const std::vector<std::filesystem::path>& files,
                                      const VolumeChoice& choice);

}  // namespace multitetra
