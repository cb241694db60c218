// FreeSurfer's MGH volumes: .mgh, and .mgz compressed by gzip.
#pragma once

#include <filesystem>
#include <string_view>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Returns whether a file that unpacks to this beginning is MGH. 284 bytes suffice.
[[nodiscard]] bool is_mgh(std::string_view beginning);

// World coordinates are LPS in mm, converted from RAS. choice.time selects one of several frames.
// Throws VolumeFileError.
[[nodiscard]] StoredVolume open_mgh(const std::filesystem::path& file, const VolumeChoice& choice);

}  // namespace multitetra
