#include "server/service/detail/worker_jobs.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/in_parallel.hpp"
#include "common/base/number_text.hpp"
#include "server/core/planning/budget.hpp"
#include "server/core/spectrum/spectrum_layout.hpp"
#include "server/service/catch_as_error.hpp"
#include "server/service/surface_steps.hpp"

namespace multitetra {
namespace {

// Adds the scalars to a finished step.
Result<StepResult> with_scalars(StepResult made, const DatasetInfo& surface,
                                const SurfaceProvider& field, const ScalarRange& range,
                                const std::stop_token& stop) {
  return catch_as_error("step", field.info().name, stop, [&]() -> Result<StepResult> {
    const PreparedVolume* volume = field.volume();
    if (volume == nullptr) {
      return fail(ErrorCode::kInternal,
                  "This server does not have samples of the coloring dataset.");
    }
    auto scalars = step_scalars(made.encoded, made.step.request, surface, *volume, range, stop);
    if (!scalars) return tl::unexpected(scalars.error());
    made.scalars = *std::move(scalars);
    return std::move(made);
  });
}

// Evaluation time of these maps grows with the number of places.
bool has_large_map(const IsosurfaceRequest* request) {
  constexpr std::size_t kMany = 64;
  return request && (request->thresholds.regions.size() > kMany || request->thresholds.grid);
}

Result<StepResult> make_step(const ValidatedStream& action, const StreamState& state,
                             const StepLimits& limits, const std::stop_token& stop) {
  const SurfaceProvider& source = *action.source;
  auto made = catch_as_error("step", source.info().name, stop,
                             [&] { return make_next_step(source, state, stop, limits); });
  if (!made || made->is_over || !action.scalars) return made;
  return with_scalars(*std::move(made), source.info(), *action.scalars, *range_of(action), stop);
}

// Makes one preview each of `count` datasets, beginning with number `first`.
Result<std::vector<StepResult>> make_previews(const ValidatedStream& action, std::size_t first,
                                              std::size_t count, const StepLimits& limits,
                                              const std::stop_token& stop) {
  const StreamState state{.request = action.open.request,
                          .steps = StepPolicy::kPreviewsOnly,
                          .resumed_previews = action.open.resumed_previews,
                          .shells = action.shells};
  std::vector<std::optional<Result<StepResult>>> made(count);
  in_parallel(count, [&](std::size_t i) {
    const std::size_t at = first + i;
    const SurfaceProvider& source = at == 0 ? *action.source : *action.further[at - 1];
    made[i] = catch_as_error("preview", source.info().name, stop,
                             [&] { return make_next_step(source, state, stop, limits); });
  });
  std::vector<StepResult> previews;
  previews.reserve(count);
  for (auto& one : made) {
    if (!*one) return tl::unexpected((*one).error());
    previews.push_back(**std::move(one));
    previews.back().is_final = false;
  }
  return previews;
}

// Cached steps and first previews are fast. A later step may take as long as the whole surface.
Work step_work(const SurfaceProvider& source, const StreamState& state) {
  const std::string& dataset = source.info().name;
  const IsosurfaceRequest& request = state.request;
  // The final step of any other budget is known only once it is made.
  const bool is_known = !has_budget(request) || has_own_budget(final_step(request));
  if (is_known && source.is_cached(final_step(request))) {
    return {.kind = dataset + " remembered", .is_long = false};
  }
  if (request.cell) {
    return {.kind = dataset + " cell", .is_long = request.cell->finest_spacing < kSpectrumSpacing};
  }
  if (state.steps != StepPolicy::kFinalOnly && state.delivered.empty()) {
    return {.kind = dataset + " first preview", .is_long = false};
  }
  const char* form = !request.simplify           ? " step"
                     : request.intersection_free ? " intersection-free step"
                                                 : " simplified step";
  return {.kind = dataset + form, .is_long = true};
}

Forecast forecast_for(const Work& work, const ValidatedStream& action, std::stop_token stop) {
  const IsosurfaceRequest& requested = action.open.request;
  if (!work.is_long || requested.cell || has_budget(requested)) return {};
  return [source = action.source, request = requested, stop = std::move(stop)]() {
    const auto seconds =
        catch_as_error("forecast", source->info().name, stop, [&]() -> Result<double> {
          const SizeEstimates sizes = source->sizes(stop, SizeAccuracy::kQuick);
          if (sizes.to_fetch && sizes.to_fetch(kSpectrumSpacing) > 0) {
            return fail(ErrorCode::kUnavailable, "The spectrum has not been fetched yet.");
          }
          return source->costs().server_seconds(sizes.rough(request),
                                                form_of({.request = request}));
        });
    return seconds ? std::optional(*seconds) : std::nullopt;
  };
}

}  // namespace

Work work_for(const ValidatedStream& action, const StreamState& state, std::stop_token stop) {
  Work work = step_work(*action.source, state);
  work.is_background = action.open.priority == Priority::kBackground;
  work.forecast = forecast_for(work, action, std::move(stop));
  return work;
}

// Queries of one kind take similar times.
Work work_for(const ValidatedQuery& action) {
  const DatasetQuery& query = action.query;
  return {.kind = action.source->info().name + (is_long(query) ? " long " : " short ") +
                  kind_of(query) + (has_large_map(request_of(query)) ? " of a map" : ""),
          .is_long = is_long(query),
          .is_background = priority_of(query) == Priority::kBackground};
}

Error backlog_error(const Backlog& backlog, double limit) {
  const double share_of_time = backlog.seconds_until_done / backlog.seconds;
  const double seconds = std::ceil(std::max(1.0, (backlog.seconds - limit) * share_of_time));
  return {.code = ErrorCode::kUnavailable,
          .text = "Your pending requests already require about " +
                  shortest_text(std::ceil(backlog.seconds)) +
                  " s of this server's time; retry in " + shortest_text(seconds) + " s.",
          .retry_after = seconds};
}

Error time_limit_error(std::chrono::milliseconds limit) {
  return {ErrorCode::kLimitExceeded, "The reply takes longer than the limit of " +
                                         shortest_text(static_cast<double>(limit.count()) / 1000) +
                                         " s for one request; request a larger error."};
}

std::optional<ScalarRange> range_of(const ValidatedStream& action) {
  if (!action.scalars) return std::nullopt;
  return range_for(*action.open.scalars, action.scalars->info());
}

Result<std::vector<StepResult>> make_steps(const ValidatedStream& action, const StreamState& state,
                                           std::size_t dataset, const StepLimits& limits,
                                           const std::stop_token& stop) {
  constexpr std::size_t kPreviewsAJob = 16;
  if (!action.further.empty()) {
    const std::size_t remaining = 1 + action.further.size() - dataset;
    return make_previews(action, dataset, std::min(remaining, kPreviewsAJob), limits, stop);
  }
  auto made = make_step(action, state, limits, stop);
  if (!made) return tl::unexpected(made.error());
  std::vector<StepResult> steps;
  steps.push_back(*std::move(made));
  return steps;
}

Result<void> make_mesh(const ValidatedStream& action, std::uint64_t max_triangles,
                       StepLimits limits, const std::stop_token& stop, const std::string& what,
                       const UseSurface& use) {
  limits.as_meshes = true;
  const StreamState state{.request = action.open.request, .steps = StepPolicy::kFinalOnly};
  auto made = make_step(action, state, limits, stop);
  if (!made) return tl::unexpected(made.error());
  const std::string& dataset = action.source->info().name;
  ReceivedSurface tiles = tiles_of(*std::move(made), action.source->info(), range_of(action));
  if (const auto allowed = check_triangles(tiles.begin, max_triangles); !allowed) return allowed;
  return catch_as_error(what, dataset, stop, [&]() -> Result<void> {
    auto surface = assembled(std::move(tiles), stop);
    if (!surface) return tl::unexpected(surface.error());
    return use(*std::move(surface), stop);
  });
}

Result<DatasetQueryReply> make_answer(const ValidatedQuery& action, const std::stop_token& stop,
                                      const UseReply& use) {
  return catch_as_error(kind_of(action.query), action.source->info().name, stop, [&] {
    auto reply = answered(*action.source, action.query, stop);
    if (reply && use) {
      if (auto used = use(*reply); !used) reply = tl::unexpected(used.error());
    }
    return reply;
  });
}

}  // namespace multitetra
