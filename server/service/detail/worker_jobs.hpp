// The workers' jobs for the service of this process, with estimates of their time. Functions do not
// throw: the client gets a general error, and the log has the cause.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "server/service/permit.hpp"
#include "server/service/surface.hpp"
#include "server/service/workers.hpp"
#include "server/stream/stream_plan.hpp"

namespace multitetra {

// A kind of work whose jobs take similar times, and whether these are long, as far as is known in
// advance.
struct WorkKind {
  std::string kind;
  bool is_long = false;
};
[[nodiscard]] WorkKind work_for(const SurfaceProvider& source, const StreamState& state);
[[nodiscard]] WorkKind work_for(const SurfaceProvider& source, const DatasetQuery& query);

// Returns a forecast for steps that may be long: the time of the final step, computed from the
// spectrum alone. The forecast is nullopt if the spectrum would have to be fetched. Returns none
// for a cell, which is small, and for a budget, which may need many steps.
[[nodiscard]] Forecast forecast_for(const WorkKind& work, const StartStream& action,
                                    std::stop_token stop);

// Returns the range of a stream's scalar codes, if it has scalars.
[[nodiscard]] std::optional<ScalarRange> range_of(const StartStream& action);

// Makes the next step of a stream, with its scalars; of a stream for several datasets a group of
// previews, beginning with that of number `dataset`, on all threads.
[[nodiscard]] Result<std::vector<MadeStep>> make_steps(const StartStream& action,
                                                       const StreamState& state,
                                                       std::size_t dataset,
                                                       const StepLimits& limits,
                                                       const std::stop_token& stop);
// Makes the final surface of a request. Fails with kLimitExceeded above `max_triangles`.
[[nodiscard]] Result<Surface> make_mesh(const StartStream& action, std::uint64_t max_triangles,
                                        StepLimits limits, const std::stop_token& stop);
[[nodiscard]] Result<DatasetQueryReply> make_answer(const RunQuery& action,
                                                    const std::stop_token& stop);

// Return the errors for a share whose pending work exceeds `limit` seconds, and for a request that
// takes longer than `limit`.
[[nodiscard]] Error backlog_error(const Backlog& backlog, double limit);
[[nodiscard]] Error time_limit_error(std::chrono::milliseconds limit);

}  // namespace multitetra
