// The best model that fits into a budget of triangles and bytes.
//
// Best is what gives up least, in this order: thresholds are raised to a common floor, in steps of
// a fourth of an octave; only where no floor helps, because the topology alone takes more than the
// budget, the topology tolerance grows, by doubling. The request that was found says both.
#pragma once

#include <functional>

#include "common/request/dataset_info.hpp"
#include "common/request/isosurface_request.hpp"
#include "server/core/planning/refinement_plan.hpp"

namespace multitetra {

[[nodiscard]] inline bool has_budget(const IsosurfaceRequest& request) {
  return request.max_triangles > 0 || request.max_bytes > 0;
}

// Whether a size is within the request's budget.
[[nodiscard]] bool fits(const SurfaceSize& size, const IsosurfaceRequest& request);

// The request with the lowest rung at which `size_of` says that it fits; the request itself when it
// has no budget or fits already. `size_of` is asked some ten times.
[[nodiscard]] IsosurfaceRequest within_budget(
    const IsosurfaceRequest& request, const DatasetInfo& info,
    const std::function<SurfaceSize(const StepRequest&)>& size_of);

// The next rung above what a request has: where an estimate was too low. The same request when
// there is none.
[[nodiscard]] IsosurfaceRequest one_rung_up(const IsosurfaceRequest& request,
                                            const DatasetInfo& info);

}  // namespace multitetra
