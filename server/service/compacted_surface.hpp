// A surface whose tiles are compacted, as far as its step allows: on all threads.
#pragma once

#include <stop_token>

#include "server/core/refinement_plan.hpp"
#include "server/core/tiling.hpp"
#include "server/service/tiled_surface.hpp"

namespace multitetra {

// How the surface of a step is cut: into larger tiles when they are compacted afterwards.
[[nodiscard]] SurfaceOptions surface_options(const StepRequest& step);

// Compacts every tile when the step says so. Throws Cancelled soon after `stop` is triggered.
void compact(TiledSurface& surface, const StepRequest& step, const DatasetInfo& info,
             const std::stop_token& stop);

}  // namespace multitetra
