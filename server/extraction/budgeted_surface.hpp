// A simplified surface within its request's budget of triangles and bytes.
//
// The thresholds are raised to a common floor until the budget is met, as ErrorSchedule does, but
// in one simplification: it begins where an estimate says that the surface is still too large, goes
// on from level to level, and its last collapses are undone as far as the budget allows. The floor
// that is returned is the least that the surface keeps to.
//
//   BudgetedSurface made = surface_within_budget(extractor, request, bytes_of, stop);
//   request.thresholds.at_least = made.at_least;
//   if (!fits(size, request)) ...   // Not even the coarsest surface is within the budget.
#pragma once

#include <functional>
#include <stop_token>

#include "common/request/isosurface_request.hpp"
#include "server/extraction/surface_extractor.hpp"

namespace multitetra {

struct BudgetedSurface {
  TiledSurface surface;
  double at_least = 0;  // As LocalThresholds::at_least, in the request's unit.
};

// The encoded size of a surface in bytes. Called where the request has a budget of bytes, last with
// the surface that is returned.
using BytesOf = std::function<double(const TiledSurface&)>;

// Requires a validated request that has a budget and is simplified. A function of the dataset and
// the request alone, as `bytes_of` is of the surface. Throws Cancelled soon after `stop` is
// triggered, and DatasetFileError when the dataset turns out to be damaged.
[[nodiscard]] BudgetedSurface surface_within_budget(const SurfaceExtractor& extractor,
                                                    const IsosurfaceRequest& request,
                                                    const BytesOf& bytes_of,
                                                    const std::stop_token& stop);

}  // namespace multitetra
