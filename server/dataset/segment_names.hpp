// What the segments of a segmentation are called: 3D Slicer writes it into the headers of its
// .seg.nrrd files, as keys Segment0_Name, Segment0_Color, Segment0_LabelValue, ...
#pragma once

#include <string_view>
#include <vector>

#include "common/request/family_member.hpp"

namespace multitetra {

// In the order of their numbers, of a NRRD header's text. Segments of other layers than the first,
// and without a value, are left out; so are names and colours that are none.
[[nodiscard]] std::vector<Label> segments_in(std::string_view header);

}  // namespace multitetra
