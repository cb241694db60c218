// JPEG images, each one slice.
#pragma once

#include <filesystem>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Opens 8-bit samples as libjpeg decodes them: one component for gray images, else red, green and
// blue (four for CMYK). Refuses damaged or truncated images. Throws VolumeFileError.
[[nodiscard]] StoredVolume open_jpeg(const std::filesystem::path& file);

}  // namespace multitetra
