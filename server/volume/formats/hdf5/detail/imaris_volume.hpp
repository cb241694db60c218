// Imaris files (.ims): HDF5 with a pyramid of levels, times and channels, and extents in the world.
#pragma once

#include <optional>
#include <string>

#include "server/volume/formats/hdf5/detail/hdf5_object.hpp"
#include "server/volume/formats/volume_contents.hpp"

namespace multitetra {

struct ImarisVolume {
  std::string dataset;  // Its path in the file.
  // The size of the image; the dataset may be padded.
  std::array<std::int64_t, 3> dims{};
  // The first sample, the middle of a voxel.
  Vec3 origin{};
  Vec3 spacing{};
  std::string unit = {};
  VolumeContents members = {};
};

// The volume that `choice` names by level, time, channel, or the path of its dataset; nullopt for
// HDF5 files that are not of Imaris, and for paths that name no image. Throws VolumeFileError when
// one must be chosen.
[[nodiscard]] std::optional<ImarisVolume> imaris_volume(const std::filesystem::path& path,
                                                        hid_t file, const VolumeChoice& choice);

}  // namespace multitetra
