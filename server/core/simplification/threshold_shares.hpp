// How a request's threshold is shared between the model and simplification: the model keeps to a
// part of it everywhere, simplification of a cube to the rest of the least threshold in it. So both
// together keep to the threshold, however it differs from place to place. Only where cubes with
// different ones meet the larger counts on both sides, as far as it reaches.
#pragma once

#include "common/request/isosurface_request.hpp"

namespace multitetra {

// The model's share with simplification; all of it without. With less of it bytes at equal
// certified error hardly fall, and time grows: see the table in server/core/README.md.
inline constexpr double kModelShare = 0.05;

// What the model is asked for: the same request with its share of the thresholds.
[[nodiscard]] IsosurfaceRequest model_request(const IsosurfaceRequest& request);

}  // namespace multitetra
