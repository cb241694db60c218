// Parses thresholds as typed by users: regions and a view, one word each.
#pragma once

#include <string>
#include <string_view>

#include "common/base/result.hpp"
#include "common/request/local_thresholds.hpp"

namespace multitetra {

// Parses box:X0,Y0,Z0,X1,Y1,Z1=TAU (low corner first), ball:X,Y,Z,R=TAU or
// halfspace:NX,NY,NZ,D=TAU. Fails with kInvalidArgument, quoting the word, the fault and the
// expected form. Ranges are checked with the whole request.
[[nodiscard]] Result<ThresholdRegion> parse_region(std::string_view word);

// Parses eye=X,Y,Z,fov=DEGREES,height=PIXELS,pixels=TOLERANCE, in any order. look=X,Y,Z and
// outside=TAU add a frustum, with optional up=X,Y,Z and aspect=RATIO.
[[nodiscard]] Result<ThresholdView> parse_view(std::string_view word);

}  // namespace multitetra
