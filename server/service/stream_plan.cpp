#include "server/service/stream_plan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "server/core/budget.hpp"

namespace multitetra {
namespace {

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
                               .bytes = std::min(size.bytes, most.bytes)};
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

}  // namespace

BudgetTooSmall::BudgetTooSmall(const SurfaceSize& coarsest, const IsosurfaceRequest& request)
    : std::runtime_error("The coarsest surface has " + counted(coarsest.triangles, coarsest.bytes) +
                         ", more than the budget of " + budget_of(request) + "; allow more.") {}

MadeStep make_next_step(const StepSource& source, const StreamState& state, std::stop_token stop) {
  const DatasetInfo& info = source.info();
  const StepSizes sizes = source.sizes(stop, SizeAccuracy::kQuick);
  MadeStep made{.step = {}, .is_final = false, .encoded = {}, .after = state};
  // Finding the threshold of a budget reads samples; a first preview must not wait for that.
  const bool is_first_preview = state.previews && state.shown.empty();
  IsosurfaceRequest& request = made.after.request;
  const auto find_threshold = [&] {
    if (std::exchange(made.after.is_within_budget, true)) return;
    request = within_budget(request, info, source.sizes(stop, SizeAccuracy::kCareful).of);
  };
  if (!is_first_preview) find_threshold();
  NextStep next = next_step(request, state.previews, state.shown, info, within(sizes, request));
  if (next.is_final) {
    find_threshold();
    next.step.request = request;
  }
  made.encoded = source.make(next.step, stop);
  while (next.is_final && !fits(size_of(made.encoded), request)) {
    const IsosurfaceRequest higher = one_rung_up(request, info);
    if (higher == request) throw BudgetTooSmall(size_of(made.encoded), request);
    request = higher;
    next.step.request = higher;
    made.encoded = source.make(next.step, stop);
  }
  made.step = next.step;
  made.is_final = next.is_final;
  return made;
}

EstimatedAnswer estimate(const StepSource& source, const IsosurfaceRequest& request,
                         std::stop_token stop) {
  const StepSizes sizes = source.sizes(std::move(stop), SizeAccuracy::kCareful);
  const IsosurfaceRequest affordable = within_budget(request, source.info(), sizes.of);
  const SurfaceSize size = sizes.of({.request = affordable});
  if (!fits(size, affordable) && one_rung_up(affordable, source.info()) == affordable) {
    throw BudgetTooSmall(size, affordable);
  }
  return {.size = size, .request = affordable};
}

SurfaceSize size_of(const EncodedStep& step) {
  SurfaceSize size;
  for (const EncodedTile& tile : step.tiles) {
    size.triangles += tile.summary.triangles;
    size.bytes += tile.summary.bytes;
  }
  return size;
}

}  // namespace multitetra
