// The names of the segments of a segmentation: 3D Slicer writes them into the headers of its
// .seg.nrrd files, as keys Segment0_Name, Segment0_Color, Segment0_LabelValue, ...
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// In the order of their numbers, of a NRRD header's text. Labels have the segments' values; where
// segments lie in several layers, in each of which values start over, they are numbered from 1 on.
// Segments without a value are left out, those whose value another one has, and those of more than
// so many layers; so are names and colors that are none.
[[nodiscard]] std::vector<SourceLabel> segments_in(std::string_view header,
                                                   std::int64_t most_layers = kMaxComponents);

}  // namespace multitetra
