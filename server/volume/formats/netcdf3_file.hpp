// NetCDF-3: the classic format, its 64-bit offsets (CDF-2) and 64-bit data (CDF-5). NetCDF-4 is
// HDF5.
#pragma once

#include <filesystem>
#include <string_view>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

[[nodiscard]] bool is_netcdf3(std::string_view beginning);

// The variable called choice.array; without a name the only one with two or more dimensions. Its
// last three dimensions are z, y, x, and their coordinate variables give its place, where they are
// even; further ones are chosen by choice.time and choice.channel. scale_factor, add_offset,
// _FillValue or missing_value and units are those of the variable. Throws VolumeFileError.
[[nodiscard]] StoredVolume open_netcdf3(const std::filesystem::path& file,
                                        const VolumeChoice& choice);

}  // namespace multitetra
