// NumPy arrays (.npy), and archives of them (.npz): 2 to 5 dimensions of numbers.
#pragma once

#include <filesystem>
#include <string_view>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

[[nodiscard]] bool is_npy(std::string_view beginning);

// Opens the only array of numbers with two or more dimensions, or choice.array of an archive. The
// last three dimensions are z, y, x, as for all arrays; choice.time selects along the first of
// four. The fastest axis of arrays in Fortran order is therefore z. Throws VolumeFileError.
[[nodiscard]] StoredVolume open_npy(const std::filesystem::path& file, const VolumeChoice& choice);

}  // namespace multitetra
