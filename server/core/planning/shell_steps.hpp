// Steps of sample shells: which ones a request can have, and which of them meets it.
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

// Returns whether the dataset has such shells: exact ones require integer samples, lattice-exact
// ones at most 256 lattice steps an edge, and the format limits spacings and isovalues.
[[nodiscard]] bool has_shells(const DatasetInfo& info, const ShellLevel& level);

// Returns whether a request can have steps of shells, which are whole surfaces without normals.
[[nodiscard]] inline bool allows_shells(const IsosurfaceRequest& request) {
  return !request.cell && request.normal_bits == 0;
}

// Returns the full-resolution shells with the fewest bytes that meet all thresholds of the request,
// or nullopt if the dataset has none.
[[nodiscard]] std::optional<StepRequest> certified_shells(const IsosurfaceRequest& request,
                                                          const DatasetInfo& info);

// Returns whether a step of shells suffices for a client that keeps no mesh: full resolution,
// within all thresholds, which are below a voxel somewhere, and no budget. Depends only on request
// and step, so that a stream resumed on another server ends with the same step.
[[nodiscard]] bool is_enough_to_display(const StepRequest& step, const IsosurfaceRequest& request,
                                        const DatasetInfo& info);

}  // namespace multitetra
