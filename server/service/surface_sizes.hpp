// How large the surfaces of a dataset are, without extracting them: core's samples of octree cubes,
// counted on all threads.
#pragma once

#include <stop_token>

#include "server/core/prepared_volume.hpp"
#include "server/core/refinement_plan.hpp"

namespace multitetra {

// Estimates within some ten percent. The functions throw Cancelled soon after `stop` is triggered;
// the dataset must outlive them.
[[nodiscard]] StepSizes surface_sizes(const PreparedVolume& dataset, std::stop_token stop = {});

}  // namespace multitetra
