// Cube files of quantum chemistry (.cube, .cub): text.
#pragma once

#include <filesystem>
#include <string_view>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Whether a text that begins so is a cube file: two lines of comment, then the four lines of the
// grid.
[[nodiscard]] bool is_cube(std::string_view beginning);

// Cube files have their third axis fastest, so that is x here, and the first one is z; world
// coordinates are the file's own. Lengths are in bohr, or in Å if the file says so. Throws
// VolumeFileError.
[[nodiscard]] StoredVolume open_cube(const std::filesystem::path& file);

}  // namespace multitetra
