// Which models a progressive stream shows on its way to the one that was asked for.
#pragma once

#include <cstdint>
#include <vector>

#include "common/dataset_info.hpp"
#include "common/isosurface_request.hpp"

namespace multitetra {

// One step of a stream: a request, and where its hierarchy ends.
struct StepRequest {
  IsosurfaceRequest request;
  std::int32_t finest_spacing =
      1;  // Grid steps, a power of two: no finer dividing point takes part.

  friend bool operator==(const StepRequest&, const StepRequest&) = default;
};

// Previews with falling error, topology tolerance and finest spacing, then exactly `request`.
// Without `previews` only the request itself. Previews that the grid is too small for are left out.
[[nodiscard]] std::vector<StepRequest> plan_steps(const IsosurfaceRequest& request, bool previews,
                                                  const DatasetInfo& info);

}  // namespace multitetra
