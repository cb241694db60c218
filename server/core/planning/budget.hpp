// The best model that fits into a budget of triangles and bytes.
//
// The best one has the smallest errors: thresholds are raised to a common floor, in steps of a
// fourth of an octave. A budget never changes the topology; a request may allow that explicitly.
//
//   const ErrorSchedule schedule(request, info);
//   const int level = schedule.lowest_fitting(size_of);
//   const IsosurfaceRequest affordable = schedule.at(level);
#pragma once

#include <functional>
#include <optional>

#include "common/request/dataset_info.hpp"
#include "common/request/isosurface_request.hpp"
#include "server/core/planning/refinement_plan.hpp"

namespace multitetra {

[[nodiscard]] inline bool has_budget(const IsosurfaceRequest& request) {
  return request.max_triangles > 0 || request.max_bytes > 0;
}

// Whether the step keeps to the request's budget while it is made: a final one that is simplified.
[[nodiscard]] inline bool has_own_budget(const StepRequest& step) {
  return step.request.simplify && step.finest_spacing == 1 && has_budget(step.request);
}

// The part of the request's budget that a size takes: more than 1 when it does not fit; 0 without a
// budget.
[[nodiscard]] double part_of_budget(const SurfaceSize& size, const IsosurfaceRequest& request);

[[nodiscard]] inline bool fits(const SurfaceSize& size, const IsosurfaceRequest& request) {
  return part_of_budget(size, request) <= 1;
}

// Requests that allow more and more. Level 0 is the request itself; from level to level its
// thresholds' floor rises, up to the side of the grid. Levels below the request's own error are
// left out.
class ErrorSchedule {
 public:
  using SizeOf = std::function<SurfaceSize(const StepRequest&)>;

  ErrorSchedule(const IsosurfaceRequest& request, const DatasetInfo& info);

  [[nodiscard]] int size() const { return 1 + floors_ - below_; }
  [[nodiscard]] int last() const { return size() - 1; }
  [[nodiscard]] IsosurfaceRequest at(int level) const;

  // The lowest level in [from, to) whose size takes at most `part` of the budget; `to` when none
  // does. 0 without a budget. Calls `size_of` about six times.
  [[nodiscard]] int lowest_fitting(const SizeOf& size_of, int from, int to, double part) const;
  // Over all levels, with a margin for wrong estimates. The last level when none fits.
  [[nodiscard]] int lowest_fitting(const SizeOf& estimate) const;

 private:
  IsosurfaceRequest request_;
  double unit_;    // A voxel, in the unit of the request.
  int floors_;     // From a sixteenth of a voxel on.
  int below_ = 0;  // Floors that would not raise any threshold.
};

// A surface that was made, and the part of the budget that it takes.
struct TriedLevel {
  int level = 0;
  double part = 0;
};

// The level to make next, strictly between the highest that was too large and the lowest that fits,
// if there is one. Sizes fall about as a power of the threshold: between two made levels the
// logarithm of the size is interpolated linearly, and the estimate (`estimated`) is used as far as
// the power stays between 1 (upwards a fourth: a too coarse level costs little) and 4. Requires
// that one of them is there, and a level between them.
[[nodiscard]] int next_level(const std::optional<TriedLevel>& too_large,
                             const std::optional<TriedLevel>& fitting, int estimated, int last);

// The next error of a simplification that left too much: sizes are extrapolated from those since
// `before`. Requires made.part > 1, and a level beyond it; at most four octaves are left out.
[[nodiscard]] int coarser_level(const std::optional<TriedLevel>& before, const TriedLevel& made,
                                int last);
// The level to start from, when the first one fits. Requires a level before that one.
[[nodiscard]] int finer_level(const TriedLevel& made);

// The request as its budget allows it; the request itself when it has none or fits already.
[[nodiscard]] IsosurfaceRequest within_budget(const IsosurfaceRequest& request,
                                              const DatasetInfo& info,
                                              const ErrorSchedule::SizeOf& estimate);

}  // namespace multitetra
