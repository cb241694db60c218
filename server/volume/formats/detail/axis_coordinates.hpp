// Places a volume whose file lists coordinates for each dimension, as HDF5 and NetCDF do.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// The coordinates along an axis. Without values, samples are 1 apart.
struct AxisCoordinates {
  std::vector<double> values = {};
  // The unit's name in the file.
  std::string unit = {};
  // Replaces `values`; coordinates start at 0.
  std::optional<double> step = std::nullopt;
};

// Sets the placement of a volume along x, y, z; `coordinates` are known for the first `axes` axes.
// Sets a length unit only if all of these share it. Ignores unevenly spaced coordinates, with a
// notice; `path` names the source in it.
void place_by_coordinates(const std::filesystem::path& path,
                          const std::array<AxisCoordinates, 3>& coordinates, std::size_t axes,
                          ImageHeader& header, std::vector<std::string>& notices);

}  // namespace multitetra
