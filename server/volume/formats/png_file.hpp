// PNG images, each one slice.
#pragma once

#include <filesystem>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Opens 8-bit or 16-bit samples as stored: palette indices, or all color components. Throws
// VolumeFileError.
[[nodiscard]] StoredVolume open_png(const std::filesystem::path& file);

}  // namespace multitetra
