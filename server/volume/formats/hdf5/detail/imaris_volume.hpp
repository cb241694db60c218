// Imaris files (.ims): HDF5 with a pyramid of levels, times and channels, and world extents.
#pragma once

#include <optional>
#include <string>

#include "server/volume/formats/hdf5/detail/hdf5_object.hpp"
#include "server/volume/formats/volume_contents.hpp"

namespace multitetra {

struct ImarisVolume {
  std::string dataset;  // Path of the dataset in the file.
  // Size of the image; the dataset may be padded.
  std::array<std::int64_t, 3> dims{};
  // The first sample: the center of a voxel.
  StatedNumbers origin = kNotStated;
  StatedNumbers spacing = kNotStated;
  std::string unit = {};
  VolumeContents contents = {};
};

// Finds the volume of `choice`: by level, time and channel, or by the path of its dataset. Returns
// nullopt if the file is not from Imaris or the path is no image. Throws VolumeFileError if a
// choice is required.
[[nodiscard]] std::optional<ImarisVolume> imaris_volume(const std::filesystem::path& path,
                                                        hid_t file, const VolumeChoice& choice);

}  // namespace multitetra
