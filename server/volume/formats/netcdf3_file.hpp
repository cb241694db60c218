// NetCDF-3: the classic format, 64-bit offsets (CDF-2) and 64-bit data (CDF-5). NetCDF-4 is HDF5.
#pragma once

#include <filesystem>
#include <string_view>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

[[nodiscard]] bool is_netcdf3(std::string_view beginning);

// Opens the variable choice.array, or the only one with two or more dimensions. Its last three
// dimensions are z, y, x, placed by their coordinate variables if these are evenly spaced;
// choice.time and choice.channel select along earlier ones. Uses the variable's scale_factor,
// add_offset, _FillValue or missing_value, and units. Throws VolumeFileError.
[[nodiscard]] StoredVolume open_netcdf3(const std::filesystem::path& file,
                                        const VolumeChoice& choice);

}  // namespace multitetra
