// NumPy arrays (.npy): 2 to 4 dimensions of numbers.
#pragma once

#include <filesystem>
#include <string_view>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

[[nodiscard]] bool is_npy(std::string_view beginning);

// The last three dimensions are z, y, x, as for all arrays; choice.time selects along the first of
// four. The fastest axis of arrays in Fortran order is therefore z. Throws VolumeFileError.
[[nodiscard]] StoredVolume open_npy(const std::filesystem::path& file, const VolumeChoice& choice);

}  // namespace multitetra
