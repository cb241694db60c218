// Reads HDF5 files by libhdf5: plain ones, and those of the conventions in arrays/conventions/.
#pragma once

#include <filesystem>
#include <string_view>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Returns whether a file with this beginning is HDF5. 8 bytes suffice.
[[nodiscard]] bool is_hdf5(std::string_view beginning);

// Opens the dataset choice.array, the only one that a convention offers, or the only one with two
// or more dimensions. Unless dimensions are named, the last one is x, preceded by y and z;
// choice.time and choice.channel select along earlier ones. Without a convention, evenly spaced
// dimension scales, or `element_size_um` (z, y, x) of microscopes, give origin, spacing and unit;
// attributes are used as in NetCDF. Throws VolumeFileError.
[[nodiscard]] StoredVolume open_hdf5(const std::filesystem::path& file, const VolumeChoice& choice);

}  // namespace multitetra
