// Arrays of NumPy (.npy): 2 to 4 dimensions of numbers.
#pragma once

#include <filesystem>
#include <string_view>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

[[nodiscard]] bool is_npy(std::string_view beginning);

// The last three dimensions are z, y, x, as in all arrays here; of four the first is chosen by
// choice.time. Arrays in the order of Fortran keep their places in the world: there the axis that
// varies fastest is z. Throws VolumeFileError.
[[nodiscard]] StoredVolume open_npy(const std::filesystem::path& file, const VolumeChoice& choice);

}  // namespace multitetra
