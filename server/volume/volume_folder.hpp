// Finds the volumes in a folder.
#pragma once

#include <filesystem>
#include <vector>

namespace multitetra {

// Returns the files and folders below `folder` that read_volume accepts, sorted by name. A folder
// with DICOM or TIFF images or an array counts as one volume. Omits data files with a description
// beside them, hidden files, datasets, and everything that is no volume. Throws VolumeFileError if
// a folder cannot be read.
[[nodiscard]] std::vector<std::filesystem::path> volumes_in(const std::filesystem::path& folder);

}  // namespace multitetra
