// How large the surfaces of a dataset are, without extracting them: core's samples of octree cubes,
// counted on all threads.
#pragma once

#include <stop_token>

#include "server/core/refinement_plan.hpp"

namespace multitetra {

class SurfaceExtractor;

// Estimates within some ten percent. The functions throw Cancelled soon after `stop` is triggered;
// the extractor must outlive them.
[[nodiscard]] StepSizes surface_sizes(const SurfaceExtractor& extractor,
                                      std::stop_token stop = {});

}  // namespace multitetra
