// Parallel XML VTK image data (.pvti): a volume in pieces, each in a .vti file.
#pragma once

#include <filesystem>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// The pieces must be in the folder of `file`, or anywhere with choice.follow, and cover the whole
// extent; where they overlap, the last one wins. choice.array applies to every piece. Throws
// VolumeFileError.
[[nodiscard]] StoredVolume open_pvti(const std::filesystem::path& file, const VolumeChoice& choice);

}  // namespace multitetra
