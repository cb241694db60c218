// Parses thresholds as they are typed: regions and a view, one word each.
#pragma once

#include <string>
#include <string_view>

#include "common/base/result.hpp"
#include "common/request/local_thresholds.hpp"

namespace multitetra {

// box:X0,Y0,Z0,X1,Y1,Z1=TAU (no low coordinate above its high one), ball:X,Y,Z,R=TAU,
// halfspace:NX,NY,NZ,D=TAU. kInvalidArgument, quoting the word, what is wrong with it and what
// would be right. Ranges are checked where the whole request is.
[[nodiscard]] Result<ThresholdRegion> parse_region(std::string_view word);

// eye=X,Y,Z,fov=DEGREES,height=PIXELS,pixels=TOLERANCE, in any order, and for a frustum
// look=X,Y,Z and outside=TAU, with which up=X,Y,Z and aspect=RATIO may be given.
[[nodiscard]] Result<ThresholdView> parse_view(std::string_view word);

}  // namespace multitetra
