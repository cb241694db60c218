// Several volumes in one NRRD of four axes: the axis that is none of space, the last or the first,
// counts their times.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "server/dataset/formats/source_members.hpp"

namespace multitetra {

struct NrrdSeries {
  SourceTimes times;
  // The times are the first axis, so that a sample has a number for each. Else the volumes follow
  // each other.
  bool is_interleaved = false;
};

// Of a header's text: by the axes' kinds (time, list, none; a list that `is_component` chooses from
// is no series), else by the axis without a direction, else the last of four. Times are those of 3D
// Slicer's keys ("axis 0 index values"), or what spacing, least place and unit of the axis say.
// nullopt: it has no such axis.
[[nodiscard]] std::optional<NrrdSeries> nrrd_series(std::string_view header, bool is_component);

// The header, detached, of one volume of a series that is not interleaved. Names of data files are
// absolute. Throws VolumeFileError when its samples are text, or lie in files that no volume fills.
[[nodiscard]] std::string nrrd_header_at(std::string_view header, const std::filesystem::path& file,
                                         std::int64_t time);

}  // namespace multitetra
