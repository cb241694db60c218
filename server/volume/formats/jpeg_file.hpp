// JPEG images, each a slice.
#pragma once

#include <filesystem>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Samples of 8 bits as libjpeg decodes them: one of grey images, red, green and blue of colors
// (four of CMYK). An image that is damaged or ends early is refused. Throws VolumeFileError.
[[nodiscard]] StoredVolume open_jpeg(const std::filesystem::path& file);

}  // namespace multitetra
