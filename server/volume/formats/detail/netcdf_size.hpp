// The size of files of the netCDF library.
#pragma once

#include <cstdint>
#include <optional>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Returns the type of an nc_type; nullopt for texts and types of users.
[[nodiscard]] std::optional<StoredType> netcdf_type(int type);

// Returns the least bytes that an open classic file (netCDF 3) of this format has: its header, and
// the variables without gaps. The library reads zeros behind the end of a file. See "NetCDF Classic
// Format Specification".
[[nodiscard]] std::uint64_t least_classic_bytes(int id, int format);

}  // namespace multitetra
