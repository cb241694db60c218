// Which models a progressive stream shows on its way to the one that was asked for.
#pragma once

#include <cstdint>
#include <vector>

#include "common/isosurface_request.hpp"

namespace multitetra {

// One step of a stream: a request, and where its hierarchy ends.
struct StepRequest {
  IsosurfaceRequest request;
  std::int32_t finest_spacing =
      1;  // Grid steps, a power of two: no finer dividing point takes part.

  friend bool operator==(const StepRequest&, const StepRequest&) = default;
};

// Previews with falling error and topology tolerance, then exactly `request`. Without `previews`
// only the request itself. `voxel_length` is the length of one voxel in world units. Previews are
// not made where they would be no coarser than the request.
[[nodiscard]] std::vector<StepRequest> plan_steps(const IsosurfaceRequest& request, bool previews,
                                                  double voxel_length);

}  // namespace multitetra
