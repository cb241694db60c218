// A surface that is compacted, as far as its step allows: on all threads.
#pragma once

#include <functional>
#include <stop_token>

#include "server/core/compacted_cube.hpp"
#include "server/core/refinement_plan.hpp"
#include "server/service/tiled_surface.hpp"

namespace multitetra {

// How the surface in a cube is compacted. A cube inside of it must not have a smaller budget.
using CompactionOfCubes = std::function<CompactionOptions(const OctreeCube&)>;

// Compacts the surface in a grid of 2^exponent steps a side, and cuts it into tiles anew. The same
// for any number of threads. Throws Cancelled soon after `stop` is triggered.
void compact(TiledSurface& surface, int grid_exponent, const CompactionOfCubes& how,
             const std::stop_token& stop, const CompactedTileLimits& limits = {});

// The same as far as the step says so.
void compact(TiledSurface& surface, const StepRequest& step, const DatasetInfo& info,
             const std::stop_token& stop);

}  // namespace multitetra
