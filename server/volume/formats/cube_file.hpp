// Cube files of quantum chemistry (.cube, .cub): text.
#pragma once

#include <filesystem>
#include <string_view>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Returns whether a text with this beginning is a cube file: two comment lines and a grid.
[[nodiscard]] bool is_cube(std::string_view beginning);

// The third axis of a cube file varies fastest, so it becomes x, and the first becomes z; world
// coordinates are those of the file. Lengths are in bohr, or in Å if the file says so. Throws
// VolumeFileError.
[[nodiscard]] StoredVolume open_cube(const std::filesystem::path& file);

}  // namespace multitetra
