// PNG images, each a slice.
#pragma once

#include <filesystem>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Samples are taken as they are stored, with 8 or 16 bits: of images with a palette their indices,
// of colors all components. Throws VolumeFileError.
[[nodiscard]] StoredVolume open_png(const std::filesystem::path& file);

}  // namespace multitetra
