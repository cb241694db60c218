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
// DICOMDIR are left out.
[[nodiscard]] std::vector<std::filesystem::path> dicom_files(const std::filesystem::path& folder);

// The volume that the files of one series make up. Slices are sorted by position; world coordinates
// are LPS in mm; slope and intercept are the header's. Of several series choice.series names one;
// of several images at each position choice.time chooses one. Throws VolumeFileError, also where
// slices are missing or not evenly spaced, and for a tilted gantry. `place` is the source's name.
[[nodiscard]] StoredVolume open_dicom(const std::filesystem::path& place,
                                      const std::vector<std::filesystem::path>& files,
                                      const VolumeChoice& choice);

}  // namespace multitetra
