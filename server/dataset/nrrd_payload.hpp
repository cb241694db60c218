// Where the samples of a NRRD lie, from its header's text.
//
// ITK reads NRRD headers, but does not tell where the samples begin. What is not understood here to
// the last word, ITK reads as a whole: nothing is guessed.
#pragma once

#include <filesystem>
#include <optional>

#include "server/dataset/image_file.hpp"
#include "server/dataset/plain_payload.hpp"

namespace multitetra {

// Throws VolumeFileError unless the header of the NRRD `file` is one that ITK can be trusted with:
// ITK hands the pattern that names data files to printf as it is, and counts them one by one. Data
// files must be regular files in the header's folder (or anywhere with `follow`).
void check_nrrd_header(const std::filesystem::path& file, bool follow);

// The payload of the NRRD `file` (.nrrd or .nhdr) whose header ITK reads as `header`; nullopt when
// its encoding is text, its parts are smaller than slices, or the header is unusual. Requires
// dims within the largest grid.
[[nodiscard]] std::optional<PlainPayload> plain_nrrd_payload(const std::filesystem::path& file,
                                                             const ImageHeader& header);

}  // namespace multitetra
