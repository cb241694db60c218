// Steps of sample shells: which a request can have, and which of them meets it.
#pragma once

#include <cstdint>
#include <optional>

#include "server/core/planning/refinement_plan.hpp"

namespace multitetra {

// The parameters that determine a set of shells, besides the dataset.
struct ShellLevel {
  double isovalue = 0;
  int lattice_resolution = kDefaultLatticeResolution;
  std::int32_t finest_spacing = 1;
  ShellStep shell = {};
};

// Requires a step of shells.
[[nodiscard]] inline ShellLevel level_of(const StepRequest& step) {
  return {.isovalue = step.request.isovalue,
          .lattice_resolution = step.request.lattice_resolution,
          .finest_spacing = step.finest_spacing,
          .shell = *step.shell};
}

// Whether the dataset has such shells: exact ones need integer samples, lattice-exact ones at most
// 256 lattice steps an edge, and the format has a largest spacing and isovalues that it can hold.
[[nodiscard]] bool has_shells(const DatasetInfo& info, const ShellLevel& level);

// Whether a request can have steps of shells, which are whole surfaces without normals.
[[nodiscard]] inline bool allows_shells(const IsosurfaceRequest& request) {
  return !request.cell && request.normal_bits == 0;
}

// The full-resolution shells with the fewest bytes that are within all thresholds of the request;
// none where the dataset has none.
[[nodiscard]] std::optional<StepRequest> certified_shells(const IsosurfaceRequest& request,
                                                          const DatasetInfo& info);

// Whether a step of shells is all that a client needs that keeps no mesh: full resolution, within
// all thresholds, where these allow less than a voxel and there is no budget. A function of request
// and step alone, so that a stream that is resumed elsewhere ends with the same step.
[[nodiscard]] bool is_enough_to_display(const StepRequest& step, const IsosurfaceRequest& request,
                                        const DatasetInfo& info);

}  // namespace multitetra
