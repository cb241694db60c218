// Estimates the sizes of a dataset's surfaces without extracting them, by sampling octree cubes on
// all threads. With simplification, sampled blocks are simplified, and small surfaces are built.
#pragma once

#include <stop_token>

#include "server/core/planning/refinement_plan.hpp"

namespace multitetra {

class SurfaceExtractor;

enum class SizeAccuracy {
  // The accuracy for planning a stream: within about a factor of 1.5, in milliseconds. With
  // simplification, from four blocks, less accurate (at most three times too large on public
  // volumes) and slower.
  kQuick,
  // The accuracy for estimates shown to clients: a larger sample, whose blocks are encoded to
  // measure bytes.
  kAccurate,
};

// Returns functions that are not thread-safe and throw Cancelled soon after `stop` is triggered.
// The extractor must outlive them.
[[nodiscard]] SizeEstimates surface_sizes(const SurfaceExtractor& extractor,
                                          std::stop_token stop = {},
                                          SizeAccuracy accuracy = SizeAccuracy::kQuick);

}  // namespace multitetra
