// Parallel XML VTK image data (.pvti): a volume in pieces, each a .vti file of its own.
#pragma once

#include <filesystem>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Pieces lie in the folder of `file`, or anywhere with choice.follow, and cover the whole extent;
// where they overlap the later one counts. choice.array is that of every piece. Throws
// VolumeFileError.
[[nodiscard]] StoredVolume open_pvti(const std::filesystem::path& file, const VolumeChoice& choice);

}  // namespace multitetra
