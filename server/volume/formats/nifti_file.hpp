// NIfTI-1 and NIfTI-2: .nii, .nii.gz, and .hdr beside .img.
#pragma once

#include <filesystem>
#include <string_view>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Whether a file that begins so is NIfTI. 540 bytes are enough.
[[nodiscard]] bool is_nifti(std::string_view beginning);

// World coordinates are LPS (NIfTI itself is RAS), from the sform or else the qform; without either
// the axes are the file's own. Slope and intercept are told in the header. Samples along the fourth
// dimension are times (choice.time), along the fifth components (choice.component). Throws
// VolumeFileError.
[[nodiscard]] StoredVolume open_nifti(const std::filesystem::path& file,
                                      const VolumeChoice& choice);

}  // namespace multitetra
