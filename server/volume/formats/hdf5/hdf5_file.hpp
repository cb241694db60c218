// Reads HDF5 files, including NetCDF-4, by libhdf5.
#pragma once

#include <filesystem>
#include <string_view>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Returns whether a file with this beginning is HDF5. 8 bytes suffice.
[[nodiscard]] bool is_hdf5(std::string_view beginning);

// Opens the dataset choice.array, or the only one with two or more dimensions. The last dimension
// is x, preceded by y and z; choice.time and choice.channel select along earlier ones. Evenly
// spaced dimension scales, or `element_size_um` (z, y, x) of microscopes, give origin, spacing and
// unit; scale_factor, add_offset, _FillValue and units are used as in NetCDF. Throws
// VolumeFileError.
[[nodiscard]] StoredVolume open_hdf5(const std::filesystem::path& file, const VolumeChoice& choice);

}  // namespace multitetra
