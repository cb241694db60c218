// MRC and CCP4 maps of electron microscopy and crystallography (.mrc, .map, .ccp4, also gzipped).
#pragma once

#include <filesystem>
#include <string_view>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Returns whether a file with this beginning is MRC or CCP4. 212 bytes suffice.
[[nodiscard]] bool is_mrc(std::string_view beginning);

// Lengths are in Å. Modes 0, 1, 2, 6 and 12 (8-bit and 16-bit integers, 32-bit and 16-bit floats).
// Bytes are signed unless IMOD wrote unsigned ones, or the range in the header is beyond signed
// ones. choice.time selects one of a stack of volumes. Throws VolumeFileError.
[[nodiscard]] StoredVolume open_mrc(const std::filesystem::path& file, const VolumeChoice& choice);

}  // namespace multitetra
