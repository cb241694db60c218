#include "server/stream/stream_plan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "common/base/number_text.hpp"
#include "server/core/planning/budget.hpp"
#include "server/core/planning/shell_steps.hpp"
#include "server/stream/detail/triangle_limit.hpp"

namespace multitetra {
namespace {

// Limits rough sizes to the budget, as no surface is planned to exceed it.
SizeEstimates within(const SizeEstimates& sizes, const IsosurfaceRequest& budget) {
  SurfaceSize largest = {.triangles = std::numeric_limits<double>::infinity(),
                         .bytes = std::numeric_limits<double>::infinity()};
  if (budget.max_triangles > 0) {
    largest.triangles = static_cast<double>(budget.max_triangles);
    largest.bytes = estimated_bytes(largest.triangles, {.request = budget});
  }
  if (budget.max_bytes > 0)
    largest.bytes = std::min(largest.bytes, static_cast<double>(budget.max_bytes));
  return {.of = sizes.of,
          .rough =
              [rough = sizes.rough, largest](const IsosurfaceRequest& request) {
                const SurfaceSize size = rough(request);
                return SurfaceSize{.triangles = std::min(size.triangles, largest.triangles),
                                   .bytes = std::min(size.bytes, largest.bytes),
                                   .extracted = size.extracted};
              },
          .to_fetch = sizes.to_fetch};
}

std::string counted(double triangles, double bytes) {
  const auto rounded = [](double number) {
    return std::to_string(static_cast<std::uint64_t>(std::ceil(number)));
  };
  const std::string text = rounded(triangles) + " triangles";
  return bytes > 0 ? text + " in " + rounded(bytes) + " bytes" : text;  // Meshes have no bytes.
}

std::string budget_of(const IsosurfaceRequest& request) {
  const std::string triangles = std::to_string(request.max_triangles) + " triangles";
  const std::string bytes = std::to_string(request.max_bytes) + " bytes";
  if (request.max_bytes == 0) return triangles;
  return request.max_triangles == 0 ? bytes : triangles + " and " + bytes;
}

// A final step, and its request with the thresholds that the budget required.
struct FinalSurface {
  IsosurfaceRequest request;
  EncodedStep tiled;
};

// Returns the estimate scaled by its error for a surface that was built.
ErrorSchedule::SizeOf corrected(ErrorSchedule::SizeOf estimated, const IsosurfaceRequest& request,
                                const SurfaceSize& made) {
  const SurfaceSize expected = estimated({.request = request});
  const auto times = [](double is, double was_expected) {
    return was_expected > 0 && is > 0 ? is / was_expected : 1.0;
  };
  return
      [estimated = std::move(estimated), of_triangles = times(made.triangles, expected.triangles),
       of_bytes = times(made.bytes, expected.bytes)](const StepRequest& step) {
        SurfaceSize size = estimated(step);
        size.triangles *= of_triangles;
        size.bytes *= of_bytes;
        return size;
      };
}

// Returns the error for a budget that not even the coarsest surface fits, with the least topology
// tolerance that would; adds the estimates this needs to `sizes`.
tl::unexpected<Error> budget_too_small(CoarsestSizes& sizes, const IsosurfaceRequest& request,
                                       const SurfaceProvider& source, const std::stop_token& stop) {
  std::string text = "The budget of " + budget_of(request) + " is too small: with its ";
  text += request.topology_tolerance > 0
              ? "features above " + shortest_text(request.topology_tolerance) + " voxels kept"
              : "topology kept";
  text += " the surface has at least " + counted(sizes.kept.triangles, sizes.kept.bytes) +
          ". Allow more, or use an isovalue with a simpler surface";
  const ErrorSchedule schedule(request, source.info());
  IsosurfaceRequest tolerant = schedule.at(schedule.last());
  ErrorSchedule::SizeOf estimated;
  std::size_t octave = 0;
  for (; octave <= static_cast<std::size_t>(source.info().grid_exponent); ++octave) {
    tolerant.topology_tolerance = std::ldexp(1.0, static_cast<int>(octave));
    if (octave == sizes.tolerant.size()) {
      if (!estimated) estimated = source.sizes(stop, SizeAccuracy::kAccurate).of;
      sizes.tolerant.push_back(estimated({.request = tolerant}));
    }
    if (tolerant.topology_tolerance > request.topology_tolerance &&
        fits(sizes.tolerant[octave], request)) {
      return fail(ErrorCode::kLimitExceeded, text + ", or allow features of up to " +
                                                 shortest_text(tolerant.topology_tolerance) +
                                                 " voxels to vanish with topology_tolerance.");
    }
  }
  return fail(ErrorCode::kLimitExceeded,
              text +
                  "; no topology_tolerance fits. min_component does not help: it applies to the "
                  "finished surface.");
}

// The same for a surface that was made, whose size is kept.
tl::unexpected<Error> budget_too_small(const SurfaceSize& coarsest,
                                       const IsosurfaceRequest& request,
                                       const SurfaceProvider& source, const std::stop_token& stop) {
  CoarsestSizes sizes{.kept = coarsest};
  auto refused = budget_too_small(sizes, request, source, stop);
  // A simplification to a number of bytes may stop before the coarsest surface.
  const bool is_coarsest = !request.simplify || request.max_bytes == 0;
  if (is_coarsest) source.coarsest_sizes().keep(request, std::move(sizes));
  return refused;
}

// Fails if a coarsest surface that was made before exceeds the budget.
Result<void> check_coarsest(const IsosurfaceRequest& request, const SurfaceProvider& source,
                            const std::stop_token& stop) {
  if (!has_budget(request)) return {};
  auto known = source.coarsest_sizes().find(request);
  if (!known || fits(known->kept, request)) return {};
  auto refused = budget_too_small(*known, request, source, stop);
  source.coarsest_sizes().keep(request, *std::move(known));
  return refused;
}

// Builds a step. Budgets of bytes require encoded tiles.
EncodedStep made(const SurfaceProvider& source, const StepRequest& step, bool as_meshes,
                 const std::stop_token& stop) {
  const bool has_meshes = as_meshes && step.request.max_bytes == 0;
  return has_meshes ? source.make_meshes(step, stop) : source.make(step, stop);
}

// Searches the schedule from `level` on for a surface within the budget that uses most of it,
// unless the request's own surface uses less. Estimates only guide the search: the result is always
// built and measured. Fails with kLimitExceeded if not even the coarsest surface fits.
Result<FinalSurface> make_within_budget(const SurfaceProvider& source,
                                        const ErrorSchedule& schedule, int level, bool as_meshes,
                                        const std::stop_token& stop) {
  constexpr double kGoodPart = 0.7;
  constexpr double kAcceptablePart = 0.5;
  constexpr double kTargetPart = 0.9;
  constexpr int kFewSurfaces = 4;
  constexpr int kMaxSurfaces = 7;  // The maximum if little of the budget is used.
  std::optional<TriedLevel> too_large, fitting;
  std::optional<FinalSurface> best;
  for (int surfaces = 1;; ++surfaces) {
    const IsosurfaceRequest request = schedule.at(level);
    EncodedStep tiled = made(source, {.request = request}, as_meshes, stop);
    const SurfaceSize size = size_of(tiled);
    const double part = part_of_budget(size, request);
    if (part <= 1) {
      best = FinalSurface{.request = request, .tiled = std::move(tiled)};
      fitting = {level, part};
    } else {
      too_large = {level, part};
    }
    const int from = too_large ? too_large->level + 1 : 0;
    if (best) {
      const bool is_good = fitting->part >= kGoodPart || from == fitting->level;
      const bool is_good_enough = surfaces >= kFewSurfaces && fitting->part >= kAcceptablePart;
      if (is_good || is_good_enough || surfaces >= kMaxSurfaces) return *std::move(best);
    }
    if (from == schedule.size()) return budget_too_small(size, schedule.at(0), source, stop);
    ErrorSchedule::SizeOf estimated = source.sizes(stop, SizeAccuracy::kAccurate).of;
    const auto expected = corrected(std::move(estimated), request, size);
    const int to = fitting ? fitting->level : schedule.size();
    level = next_level(too_large, fitting, schedule.lowest_fitting(expected, from, to, kTargetPart),
                       schedule.last());
    // After repeated failures of the estimate, bisects.
    if (!best && surfaces >= kFewSurfaces) level = std::max(level, (from + schedule.last()) / 2);
  }
}

// Builds a simplified step, for which the source enforces the budget. Fails with kLimitExceeded if
// not even the coarsest surface fits.
Result<FinalSurface> make_simplified(const SurfaceProvider& source,
                                     const IsosurfaceRequest& request, bool as_meshes,
                                     const std::stop_token& stop) {
  FinalSurface last{.request = request,
                    .tiled = made(source, {.request = request}, as_meshes, stop)};
  double& at_least = last.request.thresholds.error_floor;
  at_least = std::max(at_least, last.tiled.error_floor);
  if (const SurfaceSize size = size_of(last.tiled); !fits(size, request)) {
    return budget_too_small(size, request, source, stop);
  }
  return last;
}

PlanLimits plan_limits(const StreamState& state, const StepLimits& limits) {
  PlanLimits of_plan = {.previews = state.steps != StepPolicy::kFinalOnly,
                        .shells = state.shells,
                        .is_display = state.use == MeshUse::kDisplay};
  if (of_plan.is_display && state.drawable_triangles > 0) {
    of_plan.shell_triangles = static_cast<double>(state.drawable_triangles);
  }
  if (limits.max_triangles > 0) {
    const auto max_triangles = static_cast<double>(limits.max_triangles);
    of_plan.certified_triangles = std::min(of_plan.certified_triangles, max_triangles);
    of_plan.shell_triangles = std::min(of_plan.shell_triangles, max_triangles);
  }
  if (limits.is_contended || state.steps != StepPolicy::kProgressive) {
    of_plan.certified_triangles = 0;
  }
  return of_plan;
}

// Builds a cell as requested: it is too small for previews, and has no budget.
Result<StepResult> make_cell(const SurfaceProvider& source, const StreamState& state,
                             const std::stop_token& stop, const StepLimits& limits) {
  StepResult cell{
      .step = final_step(state.request), .is_final = true, .encoded = {}, .after = state};
  cell.encoded = made(source, cell.step, limits.as_meshes, stop);
  const auto allowed =
      TriangleLimit(source, limits.max_triangles, stop).check_made(cell.step.request, cell.encoded);
  if (!allowed) return tl::unexpected(allowed.error());
  return cell;
}

// Plans the next step of a whole surface, and builds it.
class NextStepMaker {
 public:
  NextStepMaker(const SurfaceProvider& source, const StreamState& state,
                const std::stop_token& stop, const StepLimits& limits)
      : source_(source),
        state_(state),
        stop_(stop),
        limits_(limits),
        sizes_(source.sizes(stop, SizeAccuracy::kQuick)),
        triangle_limit_(source, limits.max_triangles, stop),
        schedule_(state.request, source.info()),
        made_{.after = state} {}

  Result<StepResult> make() {
    if (const auto allowed = check_request(); !allowed) return tl::unexpected(allowed.error());
    const IsosurfaceRequest request = request_to_plan();
    plan(request);
    if (made_.is_over) return std::move(made_);
    if (!made_.is_final || made_.step.shell) {
      made_.encoded = source_.make(made_.step, stop_);
      const auto allowed = check_planned();
      if (allowed && is_drawable()) return std::move(made_);
      if (is_repeated()) return tl::unexpected(allowed.error());
      made_.step = final_step(request);  // It may have fewer triangles.
      made_.is_final = true;
    }
    if (const auto is_made = make_final(); !is_made) return tl::unexpected(is_made.error());
    return std::move(made_);
  }

 private:
  [[nodiscard]] bool has_previews() const { return state_.steps != StepPolicy::kFinalOnly; }
  // Whether the step is one of the previews that a resumed stream starts with.
  [[nodiscard]] bool is_repeated() const {
    return state_.delivered.size() < state_.resumed_previews.size();
  }

  // Fails if it is certain before anything is built that the final step exceeds a limit.
  [[nodiscard]] Result<void> check_request() const {
    if (state_.delivered.empty()) {
      const auto allowed = triangle_limit_.check_estimate(state_.request, sizes_);
      if (!allowed) return allowed;
    }
    return has_previews() ? Result<void>() : check_coarsest(state_.request, source_, stop_);
  }

  [[nodiscard]] int affordable_level() {
    std::optional<int>& level = made_.after.level;
    const SizeAccuracy accuracy =
        has_own_budget(final_step(state_.request)) ? SizeAccuracy::kQuick : SizeAccuracy::kAccurate;
    if (!level) level = schedule_.lowest_fitting(source_.sizes(stop_, accuracy).of);
    return *level;
  }

  // Estimating the threshold for a budget reads samples; the first preview must not wait for it.
  [[nodiscard]] IsosurfaceRequest request_to_plan() {
    const bool is_first_preview = state_.delivered.empty() && (has_previews() || is_repeated());
    const bool is_only_step = has_own_budget(final_step(state_.request)) && !has_previews();
    if (is_first_preview || is_only_step) return state_.request;
    return schedule_.at(affordable_level());
  }

  // Sets the step, whether it is final, and whether the stream is over without it.
  void plan(const IsosurfaceRequest& request) {
    const DatasetInfo& info = source_.info();
    CostEstimates costs = source_.costs();
    costs.bytes_per_second = limits_.bytes_per_second;
    costs.client_triangles_per_second = state_.triangles_per_second;
    const PlannedStep next =
        is_repeated()
            ? PlannedStep{.step = preview_step(
                              request, state_.resumed_previews[state_.delivered.size()], info)}
            : next_step(request, plan_limits(state_, limits_), state_.delivered, info,
                        within(sizes_, request), costs);
    made_.step = next.step;
    made_.is_final = next.is_final || (state_.use == MeshUse::kDisplay &&
                                       is_enough_to_display(next.step, state_.request, info));
    made_.is_over = made_.is_final && !is_repeated() && state_.steps == StepPolicy::kPreviewsOnly &&
                    !state_.delivered.empty();
  }

  // Planned steps respect the estimated limit; explicitly requested ones may not.
  [[nodiscard]] Result<void> check_planned() const {
    const bool is_requested = made_.is_final || (is_repeated() && made_.step.finest_spacing == 1);
    if (!is_requested) return {};
    return triangle_limit_.check_made(made_.step.request, made_.encoded);
  }

  // Whether the client can draw the step; it was planned by an estimate.
  [[nodiscard]] bool is_drawable() const {
    const bool is_limited = made_.step.shell && made_.step.finest_spacing == 1 && !is_repeated() &&
                            state_.drawable_triangles > 0;
    return !is_limited ||
           size_of(made_.encoded).triangles <= static_cast<double>(state_.drawable_triangles);
  }

  // Builds the final surface within the budget and the limits.
  [[nodiscard]] Result<void> make_final() {
    const IsosurfaceRequest& request = state_.request;
    const auto allowed = check_coarsest(request, source_, stop_);
    if (!allowed) return allowed;
    Result<FinalSurface> last =
        request.simplify
            ? make_simplified(source_, request, limits_.as_meshes, stop_)
            : make_within_budget(source_, schedule_, affordable_level(), limits_.as_meshes, stop_);
    if (!last) return tl::unexpected(last.error());
    made_.step.request = std::move(last->request);
    made_.encoded = std::move(last->tiled);
    return triangle_limit_.check_made(made_.step.request, made_.encoded);
  }

  const SurfaceProvider& source_;
  const StreamState& state_;
  const std::stop_token& stop_;
  const StepLimits& limits_;
  SizeEstimates sizes_;
  TriangleLimit triangle_limit_;
  ErrorSchedule schedule_;
  StepResult made_;
};

}  // namespace

Result<StepResult> make_next_step(const SurfaceProvider& source, const StreamState& state,
                                  std::stop_token stop, const StepLimits& limits) {
  if (state.request.cell) return make_cell(source, state, stop, limits);
  return NextStepMaker(source, state, stop, limits).make();
}

Result<EstimatedAnswer> estimate(const SurfaceProvider& source, const IsosurfaceRequest& request,
                                 std::stop_token stop) {
  if (request.cell) {
    return fail(ErrorCode::kInvalidArgument, "An estimate is for a whole surface; omit the cell.");
  }
  const SizeEstimates sizes = source.sizes(stop, SizeAccuracy::kAccurate);
  const ErrorSchedule schedule(request, source.info());
  const int level = schedule.lowest_fitting(sizes.of);
  const IsosurfaceRequest affordable = schedule.at(level);
  const SurfaceSize size = sizes.of({.request = affordable});
  if (level == schedule.last() && !fits(size, affordable)) {
    CoarsestSizes estimated{.kept = size};
    return budget_too_small(estimated, request, source, stop);
  }
  return EstimatedAnswer{.size = size, .request = affordable};
}

}  // namespace multitetra
