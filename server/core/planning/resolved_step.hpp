// A step together with everything derived from it and the dataset: the thresholds of the model, the
// rest of them for simplification, the order of tiles, and the step's key.
//
//   const ResolvedStep spec(step, info);
//   const PreparedModel model(volume, ..., spec.model());
//   how = spec.simplification();
#pragma once

#include <functional>
#include <string>

#include "common/dataset/dataset_info.hpp"
#include "common/mesh/octree_cube.hpp"
#include "server/core/errors/error_based_model.hpp"
#include "server/core/planning/refinement_plan.hpp"
#include "server/core/simplification/simplification.hpp"
#include "server/core/surface/marching_tetrahedra.hpp"

namespace multitetra {

// Immutable and thread-safe.
class ResolvedStep {
 public:
  // Requires a validated request. Takes long for very many regions; `check`, if set, is called
  // repeatedly meanwhile and may throw.
  ResolvedStep(const StepRequest& step, const DatasetInfo& info,
               const std::function<void()>& check = {});

  [[nodiscard]] const StepRequest& step() const { return step_; }
  [[nodiscard]] const IsosurfaceRequest& request() const { return step_.request; }

  // Returns options with the thresholds of the model: its share of them with simplification.
  [[nodiscard]] ModelOptions model() const;
  // Returns options with the rest of the thresholds.
  [[nodiscard]] SimplificationOptions simplification() const;
  // Returns whether tiles differ in importance. The tile with the smallest send_order() comes
  // first: the smallest error is allowed there, as near the eye or in the finest region.
  [[nodiscard]] bool has_send_order() const;
  [[nodiscard]] double send_order(const OctreeCube& cube) const;

 private:
  StepRequest step_;
  Vec3 lattice_step_;
  // The request's threshold map.
  ThresholdMap thresholds_;
  ThresholdMap model_thresholds_;  // Equal to `thresholds_` without simplification.
};

// Returns a key of everything that determines a step of a dataset: equal exactly for equal steps.
// For shells, the order of tiles is not included.
[[nodiscard]] std::string key_of(const StepRequest& step, const DatasetInfo& info);

}  // namespace multitetra
