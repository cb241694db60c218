#include "server/stream/stream_plan.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "common/base/number_text.hpp"
#include "server/core/planning/budget.hpp"
#include "server/core/planning/shell_steps.hpp"

namespace multitetra {
namespace {

// Returns the factor by which a quick estimate may exceed the actual size (see SizeAccuracy).
double quick_limit_factor(const IsosurfaceRequest& request) { return request.simplify ? 3 : 1.6; }

// Limits rough sizes to the budget, as no surface is planned to exceed it.
SizeEstimates within(const SizeEstimates& sizes, const IsosurfaceRequest& budget) {
  SurfaceSize most = {.triangles = std::numeric_limits<double>::infinity(),
                      .bytes = std::numeric_limits<double>::infinity()};
  if (budget.max_triangles > 0) {
    most.triangles = static_cast<double>(budget.max_triangles);
    most.bytes = estimated_bytes(most.triangles, {.request = budget});
  }
  if (budget.max_bytes > 0)
    most.bytes = std::min(most.bytes, static_cast<double>(budget.max_bytes));
  return {.of = sizes.of,
          .rough =
              [rough = sizes.rough, most](const IsosurfaceRequest& request) {
                const SurfaceSize size = rough(request);
                return SurfaceSize{.triangles = std::min(size.triangles, most.triangles),
                                   .bytes = std::min(size.bytes, most.bytes),
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
struct FinalStep {
  IsosurfaceRequest request;
  TiledStep tiled;
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
TiledStep made(const SurfaceProvider& source, const StepRequest& step, bool as_meshes,
               const std::stop_token& stop) {
  const bool has_meshes = as_meshes && step.request.max_bytes == 0;
  return has_meshes ? source.make_meshes(step, stop) : source.make(step, stop);
}

// Searches the schedule from `level` on for a surface within the budget that uses most of it,
// unless the request's own surface uses less. Estimates only guide the search: the result is always
// built and measured. Fails with kLimitExceeded if not even the coarsest surface fits.
Result<FinalStep> make_within_budget(const SurfaceProvider& source, const ErrorSchedule& schedule,
                                     int level, bool as_meshes, const std::stop_token& stop) {
  constexpr double kGoodPart = 0.7;
  constexpr double kAcceptablePart = 0.5;
  constexpr double kTargetPart = 0.9;
  constexpr int kFewSurfaces = 4;
  constexpr int kMaxSurfaces = 7;  // The maximum if little of the budget is used.
  std::optional<TriedLevel> too_large, fitting;
  std::optional<FinalStep> best;
  for (int surfaces = 1;; ++surfaces) {
    const IsosurfaceRequest request = schedule.at(level);
    TiledStep tiled = made(source, {.request = request}, as_meshes, stop);
    const SurfaceSize size = size_of(tiled);
    const double part = part_of_budget(size, request);
    if (part <= 1) {
      best = FinalStep{.request = request, .tiled = std::move(tiled)};
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
Result<FinalStep> make_simplified(const SurfaceProvider& source, const IsosurfaceRequest& request,
                                  bool as_meshes, const std::stop_token& stop) {
  FinalStep last{.request = request, .tiled = made(source, {.request = request}, as_meshes, stop)};
  double& at_least = last.request.thresholds.at_least;
  at_least = std::max(at_least, last.tiled.at_least);
  if (const SurfaceSize size = size_of(last.tiled); !fits(size, request)) {
    return budget_too_small(size, request, source, stop);
  }
  return last;
}

// The server's limit of triangles in a final step.
class TriangleLimit {
 public:
  TriangleLimit(const SurfaceProvider& source, std::uint64_t most, std::stop_token stop)
      : source_(source), most_(most), stop_(std::move(stop)) {}

  // Rejects requests that a quick estimate shows to exceed the limit for certain. Reads samples
  // only if the spectrum's estimate, which may err either way, exceeds it.
  [[nodiscard]] Result<void> check_estimate(const IsosurfaceRequest& request,
                                            const SizeEstimates& sizes) const {
    if (most_ == 0 || request.max_bytes > 0) return {};
    if (request.max_triangles > 0 && request.max_triangles <= most_) return {};
    if (sizes.rough(request).triangles <= most()) return {};
    const double triangles = sizes.of({.request = request}).triangles;
    if (triangles <= quick_limit_factor(request) * most()) return {};
    return fail(ErrorCode::kLimitExceeded, limit_error_text("about ", triangles, request, 1));
  }
  [[nodiscard]] Result<void> check_made(const IsosurfaceRequest& request,
                                        const TiledStep& step) const {
    const double triangles = size_of(step).triangles;
    if (most_ == 0 || triangles <= most()) return {};
    if (request.cell) {
      return fail(ErrorCode::kLimitExceeded,
                  "The surface in the cell has " +
                      std::to_string(static_cast<std::uint64_t>(triangles)) +
                      " triangles; this server sends at most " + std::to_string(most_) +
                      "; request its octants, or allow a larger error.");
    }
    const double expected = accurate_sizes()({.request = request}).triangles;
    return fail(ErrorCode::kLimitExceeded,
                limit_error_text("", triangles, request,
                                 expected > 0 ? std::max(triangles / expected, 1.0) : 1));
  }

 private:
  [[nodiscard]] double most() const { return static_cast<double>(most_); }
  [[nodiscard]] std::function<SurfaceSize(const StepRequest&)> accurate_sizes() const {
    return source_.sizes(stop_, SizeAccuracy::kAccurate).of;
  }

  // `error_of_estimates` is the factor by which estimates are too small.
  [[nodiscard]] std::string limit_error_text(const std::string& about, double triangles,
                                             IsosurfaceRequest request,
                                             double error_of_estimates) const {
    request.max_triangles =
        std::max<std::uint64_t>(static_cast<std::uint64_t>(most() / error_of_estimates), 1);
    request.max_bytes = 0;
    const auto size_of_request = accurate_sizes();
    const IsosurfaceRequest fitting = within_budget(request, source_.info(), size_of_request);
    std::string text = "The surface has " + about +
                       std::to_string(static_cast<std::uint64_t>(triangles)) +
                       " triangles; this server sends at most " + std::to_string(most_);
    if (!fits(size_of_request({.request = fitting}), request)) return text + ".";
    const double error = std::max(fitting.error, fitting.thresholds.at_least);
    text += "; it fits with an error of " + shortest_text(error) + " " +
            std::string(name(request.unit)) + (request.unit == ErrorUnit::kVoxel ? "s" : " units");
    return text + ", or set a budget with max_triangles.";
  }

  const SurfaceProvider& source_;
  std::uint64_t most_;
  std::stop_token stop_;
};

PlanLimits plan_limits(const StreamState& state, const StepLimits& limits) {
  PlanLimits of_plan = {.previews = state.steps != StepPolicy::kFinalOnly,
                        .shells = state.shells,
                        .is_display = state.use == MeshUse::kDisplay};
  if (limits.max_triangles > 0) {
    const auto most = static_cast<double>(limits.max_triangles);
    of_plan.certified_triangles = std::min(of_plan.certified_triangles, most);
    of_plan.shell_triangles = std::min(of_plan.shell_triangles, most);
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

}  // namespace

Result<StepResult> make_next_step(const SurfaceProvider& source, const StreamState& state,
                                  std::stop_token stop, const StepLimits& limits) {
  if (state.request.cell) return make_cell(source, state, stop, limits);
  const DatasetInfo& info = source.info();
  const SizeEstimates sizes = source.sizes(stop, SizeAccuracy::kQuick);
  const TriangleLimit limit(source, limits.max_triangles, stop);
  if (state.delivered.empty()) {
    const auto allowed = limit.check_estimate(state.request, sizes);
    if (!allowed) return tl::unexpected(allowed.error());
  }
  const bool has_previews = state.steps != StepPolicy::kFinalOnly;
  if (!has_previews) {
    const auto allowed = check_coarsest(state.request, source, stop);
    if (!allowed) return tl::unexpected(allowed.error());
  }
  StepResult made;
  made.after = state;
  const ErrorSchedule schedule(state.request, info);
  // Estimating the threshold for a budget reads samples; the first preview must not wait for it.
  const bool is_repeated = state.delivered.size() < state.resumed_previews.size();
  const bool is_first_preview = state.delivered.empty() && (has_previews || is_repeated);
  const bool has_own = has_own_budget(final_step(state.request));
  const auto affordable = [&] {
    std::optional<int>& level = made.after.level;
    const SizeAccuracy accuracy = has_own ? SizeAccuracy::kQuick : SizeAccuracy::kAccurate;
    if (!level) level = schedule.lowest_fitting(source.sizes(stop, accuracy).of);
    return *level;
  };
  const bool is_as_requested = is_first_preview || (has_own && !has_previews);
  const IsosurfaceRequest request = is_as_requested ? state.request : schedule.at(affordable());
  CostEstimates costs = source.costs();
  costs.bytes_per_second = limits.bytes_per_second;
  costs.client_triangles_per_second = state.triangles_per_second;
  const PlannedStep next =
      is_repeated ? PlannedStep{.step = preview_step(
                                    request, state.resumed_previews[state.delivered.size()], info)}
                  : next_step(request, plan_limits(state, limits), state.delivered, info,
                              within(sizes, request), costs);
  made.step = next.step;
  made.is_final = next.is_final || (state.use == MeshUse::kDisplay &&
                                    is_enough_to_display(next.step, state.request, info));
  made.is_over = made.is_final && !is_repeated && state.steps == StepPolicy::kPreviewsOnly &&
                 !state.delivered.empty();
  if (made.is_over) return made;
  if (!made.is_final || next.step.shell) {
    made.encoded = source.make(next.step, stop);
    // Planned steps respect the estimated limit; explicitly requested ones may not.
    Result<void> allowed;
    if (made.is_final || (is_repeated && next.step.finest_spacing == 1)) {
      allowed = limit.check_made(next.step.request, made.encoded);
    }
    if (allowed) return made;
    if (is_repeated) return tl::unexpected(allowed.error());
    made.step = final_step(request);  // It may have fewer triangles.
  }
  if (const auto allowed = check_coarsest(state.request, source, stop); !allowed) {
    return tl::unexpected(allowed.error());
  }
  Result<FinalStep> last =
      state.request.simplify
          ? make_simplified(source, state.request, limits.as_meshes, stop)
          : make_within_budget(source, schedule, affordable(), limits.as_meshes, stop);
  if (!last) return tl::unexpected(last.error());
  made.step.request = std::move(last->request);
  made.encoded = std::move(last->tiled);
  const auto allowed = limit.check_made(made.step.request, made.encoded);
  if (!allowed) return tl::unexpected(allowed.error());
  return made;
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
