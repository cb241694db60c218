// MetaImage, with its samples behind the header (.mha) or in data files (.mhd).
#pragma once

#include <filesystem>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Samples are raw, zlib or text; raw ones may lie in several files, named by a list or a pattern.
// World coordinates are LPS in mm if AnatomicalOrientation declares a patient's axes, else the
// file's own. A fourth dimension has the times. Throws VolumeFileError.
[[nodiscard]] StoredVolume open_meta_image(const std::filesystem::path& file,
                                           const VolumeChoice& choice);

}  // namespace multitetra
