// NIfTI-1 and NIfTI-2 (.nii, .nii.gz, or .hdr and .img), and Analyze 7.5 (.hdr and .img).
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Returns whether a file with this beginning is NIfTI or Analyze. 540 bytes suffice.
[[nodiscard]] bool is_nifti(std::string_view beginning);

// Returns the header beside the samples `image` (.img, .img.gz); nullopt if there is none.
[[nodiscard]] std::optional<std::filesystem::path> nifti_header_of(
    const std::filesystem::path& image);

// World coordinates are LPS, converted from RAS, from the sform or else the qform; with neither,
// and for Analyze, the axes are those of the file. `file` may be the .img. The header returns slope
// and intercept. The fourth dimension contains times (choice.time), the fifth components
// (choice.component). Throws VolumeFileError.
[[nodiscard]] StoredVolume open_nifti(const std::filesystem::path& file,
                                      const VolumeChoice& choice);

}  // namespace multitetra
