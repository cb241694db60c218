// MGH volumes of FreeSurfer: .mgh, and .mgz packed with gzip.
#pragma once

#include <filesystem>
#include <string_view>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Whether a file that begins so, behind gzip, is MGH. 284 bytes are enough.
[[nodiscard]] bool is_mgh(std::string_view beginning);

// World coordinates are LPS in mm (MGH itself is RAS). Of several frames choice.time chooses one.
// Throws VolumeFileError.
[[nodiscard]] StoredVolume open_mgh(const std::filesystem::path& file, const VolumeChoice& choice);

}  // namespace multitetra
