// Divides a request's threshold between the model and simplification: the model uses a fixed share
// everywhere, simplification the rest of the least threshold over all that a collapse touches
// (allowed_distance.hpp). Together they stay within the threshold, however it varies.
#pragma once

#include "common/request/isosurface_request.hpp"

namespace multitetra {

// The model's share with simplification; without it the model gets everything. The first stage of
// simplification quickly removes what such a model keeps: see server/core/README.md.
inline constexpr double kModelShare = 0.02;

// Returns the request for the model: the same request with the model's share of the thresholds.
[[nodiscard]] IsosurfaceRequest model_request(const IsosurfaceRequest& request);

}  // namespace multitetra
