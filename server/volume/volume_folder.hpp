// The volumes in a folder of many.
#pragma once

#include <filesystem>
#include <vector>

namespace multitetra {

// The files and folders below `folder` that read_volume would take, sorted by name: a folder with
// DICOM or TIFF images or an array counts as one and is not looked into. Data files that a
// description beside them names are left out, as are hidden files, datasets, and what is no volume.
// Throws VolumeFileError when a folder cannot be read.
[[nodiscard]] std::vector<std::filesystem::path> volumes_in(const std::filesystem::path& folder);

}  // namespace multitetra
