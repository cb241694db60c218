#include "server/stream/stream_plan.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <utility>

#include "common/base/number_text.hpp"
#include "server/core/planning/budget.hpp"

namespace multitetra {
namespace {

// How much larger than the surface itself a quick estimate may be (see SizeAccuracy).
double quick_is_within(const IsosurfaceRequest& request) { return request.simplify ? 3 : 1.6; }

// A surface is never planned to be larger than its budget.
StepSizes within(const StepSizes& sizes, const IsosurfaceRequest& budget) {
  SurfaceSize most = {.triangles = std::numeric_limits<double>::infinity(),
                      .bytes = std::numeric_limits<double>::infinity()};
  if (budget.max_triangles > 0) {
    most.triangles = static_cast<double>(budget.max_triangles);
    most.bytes = estimated_bytes(most.triangles, {.request = budget});
  }
  if (budget.max_bytes > 0)
    most.bytes = std::min(most.bytes, static_cast<double>(budget.max_bytes));
  return {.of = sizes.of, .rough = [rough = sizes.rough, most](const IsosurfaceRequest& request) {
            const SurfaceSize size = rough(request);
            return SurfaceSize{.triangles = std::min(size.triangles, most.triangles),
                               .bytes = std::min(size.bytes, most.bytes),
                               .extracted = size.extracted};
          }};
}

std::string counted(double triangles, double bytes) {
  const auto rounded = [](double number) {
    return std::to_string(static_cast<std::uint64_t>(std::ceil(number)));
  };
  return rounded(triangles) + " triangles in " + rounded(bytes) + " bytes";
}

std::string budget_of(const IsosurfaceRequest& request) {
  const std::string triangles = std::to_string(request.max_triangles) + " triangles";
  const std::string bytes = std::to_string(request.max_bytes) + " bytes";
  if (request.max_bytes == 0) return triangles;
  return request.max_triangles == 0 ? bytes : triangles + " and " + bytes;
}

// A request for less than one whose surface, `made`, missed the budget; the same where there is
// none. As much as the estimate was wrong there it is taken to be wrong further up too, so that
// hardly ever another surface is made in vain.
IsosurfaceRequest after_missing(const SurfaceSize& made, const IsosurfaceRequest& request,
                                const StepSource& source, std::stop_token stop) {
  const IsosurfaceRequest higher = one_rung_up(request, source.info());
  if (higher == request) return request;
  const auto estimated = source.sizes(std::move(stop), SizeAccuracy::kCareful).of;
  const SurfaceSize expected = estimated({.request = request});
  const auto times = [](double is, double was_expected) {
    return was_expected > 0 ? std::max(is / was_expected, 1.0) : 1.0;
  };
  const double of_triangles = times(made.triangles, expected.triangles);
  const double of_bytes = times(made.bytes, expected.bytes);
  return within_budget(higher, source.info(), [&](const StepRequest& step) {
    SurfaceSize size = estimated(step);
    size.triangles *= of_triangles;
    size.bytes *= of_bytes;
    return size;
  });
}

// Not even the coarsest surface is within the budget.
tl::unexpected<Error> budget_too_small(const SurfaceSize& coarsest,
                                       const IsosurfaceRequest& request) {
  return fail(ErrorCode::kLimitExceeded,
              "The coarsest surface has " + counted(coarsest.triangles, coarsest.bytes) +
                  ", more than the budget of " + budget_of(request) + "; allow more.");
}

// The most triangles that a server gives in a final step.
class TriangleLimit {
 public:
  TriangleLimit(const StepSource& source, std::uint64_t most, std::stop_token stop)
      : source_(source), most_(most), stop_(std::move(stop)) {}

  // Refuses where a quick estimate is sure of it. Looks at samples only where the
  // spectrum alone, which may be wrong in both directions, gives reason to.
  [[nodiscard]] Result<void> check_estimate(const IsosurfaceRequest& request,
                                            const StepSizes& sizes) const {
    if (most_ == 0 || request.max_bytes > 0) return {};
    if (request.max_triangles > 0 && request.max_triangles <= most_) return {};
    if (sizes.rough(request).triangles <= most()) return {};
    const double triangles = sizes.of({.request = request}).triangles;
    if (triangles <= quick_is_within(request) * most()) return {};
    return fail(ErrorCode::kLimitExceeded, words("about ", triangles, request, 1));
  }
  [[nodiscard]] Result<void> check_made(const IsosurfaceRequest& request,
                                        const EncodedStep& step) const {
    const double triangles = size_of(step).triangles;
    if (most_ == 0 || triangles <= most()) return {};
    const double expected = careful()({.request = request}).triangles;
    return fail(
        ErrorCode::kLimitExceeded,
        words("", triangles, request, expected > 0 ? std::max(triangles / expected, 1.0) : 1));
  }

 private:
  [[nodiscard]] double most() const { return static_cast<double>(most_); }
  [[nodiscard]] std::function<SurfaceSize(const StepRequest&)> careful() const {
    return source_.sizes(stop_, SizeAccuracy::kCareful).of;
  }

  // `error_of_estimates`: by what they are to be multiplied.
  [[nodiscard]] std::string words(const std::string& about, double triangles,
                                  IsosurfaceRequest request, double error_of_estimates) const {
    const double tolerance = request.topology_tolerance;
    request.max_triangles =
        std::max<std::uint64_t>(static_cast<std::uint64_t>(most() / error_of_estimates), 1);
    request.max_bytes = 0;
    const auto size_of_request = careful();
    const IsosurfaceRequest fitting = within_budget(request, source_.info(), size_of_request);
    std::string text = "The surface has " + about +
                       std::to_string(static_cast<std::uint64_t>(triangles)) +
                       " triangles, and this server gives at most " + std::to_string(most_);
    if (!fits(size_of_request({.request = fitting}), request)) return text + ".";
    const double error = std::max(fitting.error, fitting.thresholds.at_least);
    text += "; it fits with an error of " + shortest_text(error) + " " +
            std::string(name(request.unit)) + (request.unit == LengthUnit::kVoxel ? "s" : " units");
    if (fitting.topology_tolerance > tolerance) {
      text += " and a topology tolerance of " + shortest_text(fitting.topology_tolerance);
    }
    return text + ", or name a budget with max_triangles.";
  }

  const StepSource& source_;
  std::uint64_t most_;
  std::stop_token stop_;
};

}  // namespace

Result<MadeStep> make_next_step(const StepSource& source, const StreamState& state,
                                std::stop_token stop, const StepLimits& limits) {
  const DatasetInfo& info = source.info();
  const StepSizes sizes = source.sizes(stop, SizeAccuracy::kQuick);
  const TriangleLimit limit(source, limits.max_triangles, stop);
  if (state.shown.empty()) {
    const auto allowed = limit.check_estimate(state.request, sizes);
    if (!allowed) return tl::unexpected(allowed.error());
  }
  MadeStep made;
  made.after = state;
  // Finding the threshold of a budget reads samples; a first preview must not wait for that.
  const bool is_repeated = state.shown.size() < state.begun.size();
  const bool is_first_preview = state.shown.empty() && (state.previews || is_repeated);
  IsosurfaceRequest& request = made.after.request;
  const auto find_threshold = [&] {
    if (std::exchange(made.after.is_within_budget, true)) return;
    request = within_budget(request, info, source.sizes(stop, SizeAccuracy::kCareful).of);
  };
  if (!is_first_preview) find_threshold();
  StepCosts costs = source.costs();
  costs.bytes_per_second = limits.bytes_per_second;
  NextStep next =
      is_repeated
          ? NextStep{.step = preview_step(request, state.begun[state.shown.size()], info)}
          : next_step(request, state.previews, state.shown, info, within(sizes, request), costs);
  if (next.is_final) {
    find_threshold();
    next.step.request = request;
  }
  made.encoded = source.make(next.step, stop);
  while (next.is_final && !fits(size_of(made.encoded), request)) {
    const IsosurfaceRequest less = after_missing(size_of(made.encoded), request, source, stop);
    if (less == request) return budget_too_small(size_of(made.encoded), request);
    request = less;
    next.step.request = less;
    made.encoded = source.make(next.step, stop);
  }
  if (next.is_final) {
    const auto allowed = limit.check_made(request, made.encoded);
    if (!allowed) return tl::unexpected(allowed.error());
  }
  made.step = next.step;
  made.is_final = next.is_final;
  return made;
}

Result<EstimatedAnswer> estimate(const StepSource& source, const IsosurfaceRequest& request,
                                 std::stop_token stop) {
  const StepSizes sizes = source.sizes(std::move(stop), SizeAccuracy::kCareful);
  const IsosurfaceRequest affordable = within_budget(request, source.info(), sizes.of);
  const SurfaceSize size = sizes.of({.request = affordable});
  if (!fits(size, affordable) && one_rung_up(affordable, source.info()) == affordable) {
    return budget_too_small(size, affordable);
  }
  return EstimatedAnswer{.size = size, .request = affordable};
}

}  // namespace multitetra
