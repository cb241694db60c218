// OME-Zarr images (0.4 and 0.5), plain Zarr arrays (versions 2 and 3) and N5 arrays.
#pragma once

#include <string>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Returns whether the folder, zip archive or address has Zarr or N5 metadata at its root. Links
// that lead elsewhere require `allow_external_files`.
[[nodiscard]] bool is_zarr(const std::string& place, bool allow_external_files);

// Opens the array choice.array, or the level choice.level of the image at the root (0, the finest,
// by default), or the root itself. choice.time and choice.channel select along dimensions named t
// and c; other dimensions beyond x, y, z must have length 1. Scale, translation and unit come from
// the image's metadata. Throws VolumeFileError.
[[nodiscard]] StoredVolume open_zarr(const std::string& place, const VolumeChoice& choice);

}  // namespace multitetra
