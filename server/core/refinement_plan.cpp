#include "server/core/refinement_plan.hpp"

#include <algorithm>
#include <limits>

namespace multitetra {
namespace {

// How much coarser than the request a preview is. Noise keeps most triangles of a model at any
// error while its topology is preserved, and a certified bound adds up along sharp borders; so it
// is the finest spacing f that makes a preview small, about f^2 times smaller than the full
// resolution, and the tolerance lets go what f cannot show.
struct Preview {
  std::int32_t finest_spacing;  // Grid steps.
  double error_factor;
  double least_error;  // Voxels.
  int resolution;      // Fine lattice steps are lost on coarse tetrahedra.
  std::int32_t least_side =
      0;  // Of the grid; in a large one the next preview is a large mesh itself.
};

constexpr Preview kPreviews[] = {
    {.finest_spacing = 16, .error_factor = 8, .least_error = 8, .resolution = 3, .least_side = 512},
    {.finest_spacing = 8, .error_factor = 4, .least_error = 4, .resolution = 3},
    {.finest_spacing = 4, .error_factor = 2, .least_error = 2, .resolution = 4},
};

constexpr std::int32_t kLeastStepsASide = 8;  // Of a preview's own grid.

// A request that allows large errors is a small mesh itself: its previews are coarser still.
std::int32_t coarsening(double error_in_voxels) {
  return error_in_voxels < 2 ? 1 : error_in_voxels < 8 ? 2 : 4;
}

}  // namespace

std::vector<StepRequest> plan_steps(const IsosurfaceRequest& request, bool previews,
                                    const DatasetInfo& info) {
  std::vector<StepRequest> steps;
  const double unit = request.unit == LengthUnit::kVoxel ? 1.0 : voxel_length(info);
  for (const Preview& preview : kPreviews) {
    const std::int32_t finest = preview.finest_spacing * coarsening(request.error / unit);
    const std::int32_t side = 1 << info.grid_exponent;
    if (!previews || side / finest < kLeastStepsASide || side < preview.least_side) continue;
    StepRequest step{.request = request, .finest_spacing = finest};
    step.request.error =
        std::min(std::max(preview.error_factor * request.error, preview.least_error * unit),
                 std::numeric_limits<double>::max());
    // A map goes nowhere below the preview's error, or it would ask for the full mesh in a region.
    if (!request.thresholds.is_uniform()) {
      step.request.thresholds.at_least = std::max(request.thresholds.at_least, step.request.error);
    }
    step.request.topology_tolerance = std::max(request.topology_tolerance, finest / 2.0);
    step.request.lattice_resolution = std::min(request.lattice_resolution, preview.resolution);
    steps.push_back(step);
  }
  steps.push_back({.request = request, .finest_spacing = 1});
  return steps;
}

}  // namespace multitetra
