// How a request's threshold is shared between the model and simplification: the model keeps to a
// part of it everywhere, simplification to the rest of the least threshold over what it touches
// (allowed_distance.hpp). So both together keep to the threshold, however it differs from place to
// place.
#pragma once

#include "common/request/isosurface_request.hpp"

namespace multitetra {

// The model's share with simplification; all of it without. The first stage of simplification
// leaves out quickly what the model does not: see server/core/README.md.
inline constexpr double kModelShare = 0.02;

// The request for the model: the same request with its share of the thresholds.
[[nodiscard]] IsosurfaceRequest model_request(const IsosurfaceRequest& request);

}  // namespace multitetra
