// HDF5 files through libhdf5, which is seen by hdf5_file.cpp alone; NetCDF-4 files are such files.
#pragma once

#include <filesystem>
#include <string_view>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Whether a file that begins so is HDF5. 8 bytes are enough.
[[nodiscard]] bool is_hdf5(std::string_view beginning);

// The dataset choice.array, or the only one with two or more dimensions. The last dimension is x,
// then y and z; of others before them choice.time and choice.channel choose. Evenly spaced
// dimension scales give origin, spacing and unit, as do `element_size_um` (z, y, x) of
// microscopes; the attributes scale_factor, add_offset, _FillValue and units are those of NetCDF.
// Throws VolumeFileError.
[[nodiscard]] StoredVolume open_hdf5(const std::filesystem::path& file, const VolumeChoice& choice);

}  // namespace multitetra
