// The placement of a volume whose file has a list of coordinates for each dimension, as HDF5 and
// NetCDF have.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// The coordinates of one axis. Without values, samples are 1 apart.
struct AxisCoordinates {
  std::vector<double> values = {};
  std::string unit = {};                      // As the file has it.
  std::optional<double> step = std::nullopt;  // Instead of values, from 0 on.
};

// Places a volume along x, y, z; of the first `axes` of them coordinates are known. A unit of
// length is that of all of these axes, or none. Coordinates that are not evenly spaced are not
// used, with a notice; `path` is the source's in it.
void place_by_coordinates(const std::filesystem::path& path,
                          const std::array<AxisCoordinates, 3>& coordinates, std::size_t axes,
                          ImageHeader& header, std::vector<std::string>& notices);

}  // namespace multitetra
