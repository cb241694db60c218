// Estimates the sizes of a dataset's surfaces without extracting them: core's samples of octree
// cubes, counted on all threads. With simplification the sample is simplified, and a small surface
// is made.
#pragma once

#include <stop_token>

#include "server/core/planning/refinement_plan.hpp"

namespace multitetra {

class SurfaceExtractor;

enum class SizeAccuracy {
  // To plan a stream with: within about two thirds and three halves, in milliseconds; with
  // simplification, from four blocks, rougher (at most three times too large on public volumes) and
  // slower.
  kQuick,
  // An estimate for clients: a larger sample, and its blocks are encoded to count bytes.
  kCareful,
};

// For one thread at a time. The functions throw Cancelled soon after `stop` is triggered; the
// extractor must outlive them.
[[nodiscard]] SizeEstimates surface_sizes(const SurfaceExtractor& extractor,
                                          std::stop_token stop = {},
                                          SizeAccuracy accuracy = SizeAccuracy::kQuick);

}  // namespace multitetra
