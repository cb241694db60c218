// Reads DICOM images by GDCM, with any compression it supports: the slices of a series in a folder,
// or one file with one or many frames.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Returns whether a file with this beginning is DICOM. 132 bytes suffice.
[[nodiscard]] bool is_dicom(std::string_view beginning);

// Returns the DICOM files below a folder, sorted by name. Skips hidden files and DICOMDIR. Throws
// VolumeFileError for a file that is not DICOM although its suffix is .dcm or its name differs from
// that of a DICOM file only in digits.
[[nodiscard]] std::vector<std::filesystem::path> dicom_files(const std::filesystem::path& folder);

// Opens the volume of a series. Frames and slices are sorted by position; world coordinates are LPS
// in mm; slope and intercept are per frame. choice.series selects one of several series,
// choice.time one of several images at each position. Skips localizers and images of a different
// shape, with a notice. choice.resample permits resampling if slices are missing, unevenly spaced
// (dicom_grid.hpp) or from a tilted gantry. Throws VolumeFileError, also for a truncated
// file. `place` names the source.
[[nodiscard]] StoredVolume open_dicom(const std::filesystem::path& place,
                                      const std::vector<std::filesystem::path>& files,
                                      const VolumeChoice& choice);

}  // namespace multitetra
