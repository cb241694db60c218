// NetCDF: classic, 64-bit offset, 64-bit data and NetCDF-4, by the netCDF library.
#pragma once

#include <filesystem>
#include <string_view>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Returns whether a file with this beginning is NetCDF other than NetCDF-4, which is HDF5.
[[nodiscard]] bool is_classic_netcdf(std::string_view beginning);

// The file has one variable with two or more dimensions, or choice.array is the path of one
// ("/group/name"). Attributes of the CF conventions and coordinate variables give placement, units,
// scaling and missing values; MINC 1 is read. Throws VolumeFileError.
[[nodiscard]] StoredVolume open_netcdf(const std::filesystem::path& path,
                                       const VolumeChoice& choice);

}  // namespace multitetra
