// A surface that is simplified, as far as its step allows: on all threads.
#pragma once

#include <stop_token>

#include "server/core/planning/resolved_step.hpp"
#include "server/core/simplification/simplified_cube.hpp"
#include "server/extraction/tiled_surface.hpp"

namespace multitetra {

// In seconds of the processor: of all joins, and of the longest chain of joins that wait for each
// other, which no number of threads makes shorter.
struct SimplificationWork {
  double seconds = 0;
  double longest_chain = 0;
};

// Simplifies the surface in one cube of 2^exponent steps a side, such as the whole grid, and cuts
// it into tiles anew. The same for any number of threads. Throws Cancelled soon after `stop` is
// triggered.
SimplificationWork simplify(TiledSurface& surface, int root_exponent,
                            const SimplificationOptions& options, const std::stop_token& stop,
                            const SimplifiedTileLimits& limits = {});

// The same as far as the step says so.
void simplify(TiledSurface& surface, const ResolvedStep& spec, int root_exponent,
              const std::stop_token& stop);

}  // namespace multitetra
