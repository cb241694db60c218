// A simplified surface within its request's budget of triangles and bytes.
//
// Like ErrorSchedule, raises the thresholds to a common floor until the budget is met, but in one
// simplification: it starts where an estimate is still above the budget, continues from level to
// level, and undoes the last collapses as far as the budget allows. It returns the smallest floor
// that the surface meets.
//
//   BudgetedSurface made = surface_within_budget(extractor, request, bytes_of, stop);
//   request.thresholds.error_floor = made.error_floor;
//   if (!fits(size, request)) ...   // Not even the coarsest surface is within the budget.
#pragma once

#include <functional>
#include <stop_token>

#include "common/request/isosurface_request.hpp"
#include "server/extraction/surface_extractor.hpp"

namespace multitetra {

struct BudgetedSurface {
  TiledMesh surface;
  // The floor that was found: LocalThresholds::error_floor, in the request's unit.
  double error_floor = 0;
};

// Returns the encoded bytes of a surface. Called for budgets of bytes, last with the returned one.
using BytesOf = std::function<double(const TiledMesh&)>;

// Requires a validated request with a budget and simplification. The result depends only on the
// dataset and the request, if `bytes_of` depends only on the surface. Throws Cancelled soon after
// `stop` is triggered, and DatasetFileError if the dataset is damaged.
[[nodiscard]] BudgetedSurface surface_within_budget(const SurfaceExtractor& extractor,
                                                    const IsosurfaceRequest& request,
                                                    const BytesOf& bytes_of,
                                                    const std::stop_token& stop);

}  // namespace multitetra
