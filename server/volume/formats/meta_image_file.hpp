// MetaImage, with samples after the header (.mha) or in data files (.mhd).
#pragma once

#include <filesystem>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Samples are raw, zlib or text; raw ones may be in several files, named by a list or a pattern.
// World coordinates are LPS in mm if AnatomicalOrientation declares patient axes, else those of the
// file. A fourth dimension contains times. Throws VolumeFileError.
[[nodiscard]] StoredVolume open_meta_image(const std::filesystem::path& file,
                                           const VolumeChoice& choice);

}  // namespace multitetra
