#include "server/core/planning/resolved_step.hpp"

#include "common/request/request_key.hpp"
#include "server/core/simplification/threshold_shares.hpp"

namespace multitetra {

ResolvedStep::ResolvedStep(const StepRequest& step, const DatasetInfo& info,
                           const std::function<void()>& check)
    : step_(step),
      lattice_step_(info.spacing),
      thresholds_(step.request, info, check),
      model_thresholds_(step.request.simplify
                            ? ThresholdMap(model_request(step.request), info, check)
                            : thresholds_) {
  for (double& length : lattice_step_) {
    length /= static_cast<double>(1 << step.request.lattice_resolution);
  }
}

ModelOptions ResolvedStep::model() const {
  ModelOptions options{.thresholds = model_thresholds_,
                       .topology_tolerance = step_.request.topology_tolerance,
                       .finest_spacing = step_.finest_spacing};
  if (step_.request.cell) options.refined_to = step_.request.cell->cube.side() / 2;
  return options;
}

SimplificationOptions ResolvedStep::simplification() const {
  return {.lattice_step = lattice_step_,
          .max_distance = {thresholds_, 1 - kModelShare},
          .is_intersection_free = step_.request.intersection_free};
}

bool ResolvedStep::has_send_order() const { return thresholds_.least() != thresholds_.largest(); }

double ResolvedStep::send_order(const OctreeCube& cube) const {
  return model_thresholds_.least_in(box_of(cube));
}

std::string key_of(const StepRequest& step, const DatasetInfo& info) {
  if (!step.shell) {
    return key_of(step.request) + std::to_string(step.finest_spacing) + ' ' + key_of(info);
  }
  const IsosurfaceRequest of_level = {.isovalue = step.request.isovalue,
                                      .lattice_resolution = step.request.lattice_resolution};
  return key_of(of_level) + std::to_string(step.finest_spacing) + " shells " +
         std::to_string(static_cast<int>(step.shell->values)) + ' ' +
         std::to_string(step.shell->levels_per_octave) + ' ' + key_of(info);
}

}  // namespace multitetra
