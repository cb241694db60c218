// NIfTI-1 and NIfTI-2: .nii, .nii.gz, and .hdr beside .img; Analyze 7.5, which is always the
// latter.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Whether a file that begins so is NIfTI or Analyze. 540 bytes are enough.
[[nodiscard]] bool is_nifti(std::string_view beginning);

// The header beside the samples `image` (.img, .img.gz); nullopt for other files, and where there
// is none.
[[nodiscard]] std::optional<std::filesystem::path> nifti_header_of(
    const std::filesystem::path& image);

// World coordinates are LPS (NIfTI itself is RAS), from the sform or else the qform; without either
// the axes are the file's own, as those of Analyze. `file` may be the .img. Slope and intercept are
// returned in the header. Samples along the fourth dimension are times (choice.time), along the
// fifth components (choice.component). Throws VolumeFileError.
[[nodiscard]] StoredVolume open_nifti(const std::filesystem::path& file,
                                      const VolumeChoice& choice);

}  // namespace multitetra
