// Names of segments, which 3D Slicer writes to the headers of .seg.nrrd files as keys
// Segment0_Name, Segment0_Color, Segment0_LabelValue, ...
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Returns the segments in a NRRD header, sorted by number. Labels have the segments' values; if
// segments are in several layers, where values may repeat, labels are numbered from 1. Skips
// segments without a value or with a repeated one, those beyond `max_layers` layers, and invalid
// names and colors.
[[nodiscard]] std::vector<SourceLabel> segments_in(std::string_view header,
                                                   std::int64_t max_layers = kMaxComponents);

// Throws VolumeFileError if samples have several layers of these labels and none is chosen.
void check_layers(const std::filesystem::path& file, const std::vector<SourceLabel>& labels,
                  std::int64_t layers, const VolumeChoice& choice);

}  // namespace multitetra
