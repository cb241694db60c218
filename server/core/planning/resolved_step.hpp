// A step with all that follows from it and the dataset, found out once: the thresholds of the
// model, what is left of them for simplification, which tiles come first, and what the step is
// known by.
//
//   const ResolvedStep spec(step, info);
//   const PreparedModel model(volume, ..., spec.model());
//   how = spec.simplification();
#pragma once

#include <functional>
#include <string>

#include "common/mesh/octree_cube.hpp"
#include "common/request/dataset_info.hpp"
#include "server/core/errors/error_based_model.hpp"
#include "server/core/planning/refinement_plan.hpp"
#include "server/core/simplification/simplification.hpp"
#include "server/core/surface/marching_tetrahedra.hpp"

namespace multitetra {

// Immutable; safe to use from several threads at once.
class ResolvedStep {
 public:
  // Requires a validated request. With very many regions that takes long: `check`, if there is one,
  // is called again and again meanwhile and may throw.
  ResolvedStep(const StepRequest& step, const DatasetInfo& info,
               const std::function<void()>& check = {});

  [[nodiscard]] const StepRequest& step() const { return step_; }
  [[nodiscard]] const IsosurfaceRequest& request() const { return step_.request; }

  // The thresholds of the model: with simplification its part of them.
  [[nodiscard]] ModelOptions model() const;
  // The options of simplification: the rest of the thresholds.
  [[nodiscard]] SimplificationOptions simplification() const;
  // Whether some places are more important than others; and the tile with the least number comes
  // first: where the least error is allowed, which is near the eye or in the finest region.
  [[nodiscard]] bool has_important_places() const;
  [[nodiscard]] double importance(const OctreeCube& cube) const;

 private:
  StepRequest step_;
  Vec3 lattice_step_;
  // The request's threshold map.
  ThresholdMap thresholds_;
  ThresholdMap model_thresholds_;  // The same without simplification.
};

// Everything that a step of a dataset is a function of, in bytes: equal exactly for equal steps.
// The order of a step's tiles does not count where it has shells.
[[nodiscard]] std::string key_of(const StepRequest& step, const DatasetInfo& info);

}  // namespace multitetra
