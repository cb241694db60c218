// Names and colors of labels, as segmentation programs write them into text files:
//
//   ITK-SNAP's label descriptions    3  221 130 101  1  1  1  "liver"
//   Slicer's and FreeSurfer's        3  liver  221 130 101  255
//
// One label a line: its number, then red, green and blue from 0 to 255. In the second kind the
// number after them is optional, and the name is one word or stands in double quotes; Slicer's
// underscores for spaces stay. Empty lines and those that begin with # are ignored.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "common/base/result.hpp"
#include "common/request/series_member.hpp"

namespace multitetra {

// In the order of the text. kInvalidArgument, with the line's number and what would be right, when
// a line is none of these, or names a label again.
[[nodiscard]] Result<std::vector<Label>> parse_label_names(std::string_view text);

// The same from a file of at most 4 MiB. Throws VolumeFileError.
[[nodiscard]] std::vector<Label> read_label_names(const std::filesystem::path& file);

}  // namespace multitetra
