// Names and colors of labels, from text files of segmentation programs:
//
//   ITK-SNAP's label descriptions    3  221 130 101  1  1  1  "liver"
//   Slicer's and FreeSurfer's        3  liver  221 130 101  255
//
// Each line has a label: its number, and red, green and blue from 0 to 255. In the second format
// the last number is optional, and the name is one word or in double quotes; Slicer's underscores
// for spaces are kept. Empty lines and lines that begin with # are ignored.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "common/base/result.hpp"
#include "common/dataset/series_member.hpp"

namespace multitetra {

// Returns the labels in the order of the text. Returns kInvalidArgument, with the line number and
// the expected format, if a line is invalid or repeats a label.
[[nodiscard]] Result<std::vector<Label>> parse_label_names(std::string_view text);

// Returns the labels that a sandboxed reader sends: each valid, none twice; nullopt for other
// bytes.
[[nodiscard]] std::optional<std::vector<Label>> label_names_from(std::string_view answer);

// Reads a file of at most 4 MiB. Throws VolumeFileError.
[[nodiscard]] std::vector<Label> read_label_names(const std::filesystem::path& file);

}  // namespace multitetra
