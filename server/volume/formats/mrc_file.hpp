// MRC and CCP4 maps of electron microscopy and crystallography (.mrc, .map, .ccp4, also gzipped).
#pragma once

#include <filesystem>
#include <string_view>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Whether a file that begins so is one. 212 bytes are enough.
[[nodiscard]] bool is_mrc(std::string_view beginning);

// Lengths are in Å. Modes 0, 1, 2 and 6 (integers of 8 and 16 bits, floats). Throws
// VolumeFileError, also for a cell whose axes are not at right angles.
[[nodiscard]] StoredVolume open_mrc(const std::filesystem::path& file);

}  // namespace multitetra
