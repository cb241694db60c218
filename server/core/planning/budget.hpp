// The best model that fits into a budget of triangles and bytes.
//
// The best one has the smallest errors: thresholds are raised to a common floor, in steps of a
// quarter of an octave. A budget never changes the topology unless the request allows it.
//
//   const ErrorSchedule schedule(request, info);
//   const int level = schedule.lowest_fitting(size_of);
//   const IsosurfaceRequest affordable = schedule.at(level);
#pragma once

#include <functional>
#include <optional>

#include "common/dataset/dataset_info.hpp"
#include "common/request/isosurface_request.hpp"
#include "server/core/planning/refinement_plan.hpp"

namespace multitetra {

// Returns whether the step enforces its request's budget itself: a simplified final step.
[[nodiscard]] inline bool has_own_budget(const StepRequest& step) {
  return step.request.simplify && step.finest_spacing == 1 && has_budget(step.request);
}

// Returns the fraction of the request's budget that a size uses: above 1 if too large; 0 if none.
[[nodiscard]] double part_of_budget(const SurfaceSize& size, const IsosurfaceRequest& request);

[[nodiscard]] inline bool fits(const SurfaceSize& size, const IsosurfaceRequest& request) {
  return part_of_budget(size, request) <= 1;
}

// Requests with increasing errors. Level 0 is the request itself; each level raises the floor of
// its thresholds, up to the side of the grid. Floors below the request's own error are omitted.
class ErrorSchedule {
 public:
  using SizeOf = std::function<SurfaceSize(const StepRequest&)>;

  ErrorSchedule(const IsosurfaceRequest& request, const DatasetInfo& info);

  [[nodiscard]] int size() const { return 1 + floors_ - below_; }
  [[nodiscard]] int last() const { return size() - 1; }
  [[nodiscard]] IsosurfaceRequest at(int level) const;

  // Returns the lowest level in [from, to) whose size uses at most `part` of the budget, or `to` if
  // there is none; 0 without a budget. Calls `size_of` about six times.
  [[nodiscard]] int lowest_fitting(const SizeOf& size_of, int from, int to, double part) const;
  // Searches all levels, with a margin for wrong estimates. Returns the last level if none fits.
  [[nodiscard]] int lowest_fitting(const SizeOf& estimate) const;

 private:
  IsosurfaceRequest request_;
  double unit_;    // A voxel in the unit of the request.
  int floors_;     // Number of floors, from a sixteenth of a voxel on.
  int below_ = 0;  // Number of floors that would not raise any threshold.
};

// A surface that was built, and the fraction of the budget that it uses.
struct TriedLevel {
  int level = 0;
  double part = 0;
};

// Returns the level to build next, strictly between the highest level that was too large and the
// lowest that fits. Sizes fall about as a power of the threshold: between two levels the logarithm
// of the size is interpolated linearly; with only one, `estimated` is clamped to powers between 1
// (1/4 towards coarser levels, as one that is too coarse costs little) and 4. Requires at least one
// of them, and a level between them.
[[nodiscard]] int next_level(const std::optional<TriedLevel>& too_large,
                             const std::optional<TriedLevel>& fitting, int estimated, int last);

// Returns the next level after a simplification that left too much, extrapolating sizes from those
// since `before`; skips at most four octaves. Requires made.part > 1 and a coarser level.
[[nodiscard]] int coarser_level(const std::optional<TriedLevel>& before, const TriedLevel& made,
                                int last);
// Returns the level to restart from if the first one fits. Requires a finer level.
[[nodiscard]] int finer_level(const TriedLevel& made);

// Returns the request with the errors that its budget requires; unchanged without a budget.
[[nodiscard]] IsosurfaceRequest within_budget(const IsosurfaceRequest& request,
                                              const DatasetInfo& info,
                                              const ErrorSchedule::SizeOf& estimate);

}  // namespace multitetra
