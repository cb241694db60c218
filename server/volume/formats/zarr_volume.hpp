// OME-Zarr images (0.4 and 0.5), plain Zarr arrays (versions 2 and 3) and N5 arrays.
#pragma once

#include <string>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Whether the folder, zip archive or address has metadata of Zarr or N5 at its root. Links that
// lead elsewhere are followed only with `follow`.
[[nodiscard]] bool is_zarr(const std::string& place, bool follow);

// The array choice.array, or the level choice.level of the image at the root (0, the finest, by
// default), or the root itself. Of dimensions beyond x, y, z those named t and c are chosen by
// choice.time and choice.channel; others must have one entry. Scale, translation and unit are those
// of the image's metadata. Throws VolumeFileError.
[[nodiscard]] StoredVolume open_zarr(const std::string& place, const VolumeChoice& choice);

}  // namespace multitetra
