#include "server/core/refinement_plan.hpp"

#include <algorithm>

namespace multitetra {
namespace {

// How much coarser than the request a preview is. Noise keeps most triangles of a model at any
// error while its topology is preserved, so it is the tolerance that makes a preview small.
struct Preview {
  double error_factor;
  double least_error;  // Voxels.
  double tolerance;    // Voxels.
  int resolution;      // Lattice steps matter little at such errors.
};

constexpr Preview kPreviews[] = {
    {.error_factor = 8, .least_error = 8, .tolerance = 4, .resolution = 3},
    {.error_factor = 3, .least_error = 4, .tolerance = 2, .resolution = 4},
};

}  // namespace

std::vector<StepRequest> plan_steps(const IsosurfaceRequest& request, bool previews,
                                    double voxel_length) {
  std::vector<StepRequest> steps;
  const double unit = request.unit == LengthUnit::kVoxel ? 1.0 : voxel_length;
  for (const Preview& preview : kPreviews) {
    if (!previews || request.topology_tolerance >= preview.tolerance) continue;
    StepRequest step{.request = request, .finest_spacing = 1};
    step.request.error = std::max(preview.error_factor * request.error, preview.least_error * unit);
    step.request.topology_tolerance = preview.tolerance;
    step.request.lattice_resolution = std::min(request.lattice_resolution, preview.resolution);
    steps.push_back(step);
  }
  steps.push_back({.request = request, .finest_spacing = 1});
  return steps;
}

}  // namespace multitetra
