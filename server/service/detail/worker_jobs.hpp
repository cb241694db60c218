// The workers' jobs for the service of this process, with estimates of their time. Functions do not
// throw: the client gets a general error, and the log has the cause.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "server/service/client_access.hpp"
#include "server/service/surface.hpp"
#include "server/service/surface_service.hpp"
#include "server/service/workers.hpp"
#include "server/stream/stream_plan.hpp"

namespace multitetra {

// Return the work, without `run`, that makes the next step of a stream, or answers a query. Steps
// that may be long have a forecast: the time of the final step, computed from the spectrum alone,
// or nullopt if the spectrum would have to be fetched. Cells have none, as they are small, nor have
// budgets, which may need many steps. `stop` ends the forecast.
[[nodiscard]] Work work_for(const ValidatedStream& action, const StreamState& state,
                            std::stop_token stop);
[[nodiscard]] Work work_for(const ValidatedQuery& action);

// Returns the range of a stream's scalar codes, if it has scalars.
[[nodiscard]] std::optional<ScalarRange> range_of(const ValidatedStream& action);

// Makes the next step of a stream, with its scalars; of a stream for several datasets a group of
// previews, beginning with that of number `dataset`, on all threads.
[[nodiscard]] Result<std::vector<StepResult>> make_steps(const ValidatedStream& action,
                                                         const StreamState& state,
                                                         std::size_t dataset,
                                                         const StepLimits& limits,
                                                         const std::stop_token& stop);
// Makes the final surface of a request and calls `use` to make `what` of it. Fails with
// kLimitExceeded above `max_triangles`.
[[nodiscard]] Result<void> make_mesh(const ValidatedStream& action, std::uint64_t max_triangles,
                                     StepLimits limits, const std::stop_token& stop,
                                     const std::string& what, const UseSurface& use);
// Calls `use`, if any, with the answer.
[[nodiscard]] Result<DatasetQueryReply> make_answer(const ValidatedQuery& action,
                                                    const std::stop_token& stop,
                                                    const UseReply& use);

// Return the errors for a share whose pending work exceeds `limit` seconds, and for a request that
// takes longer than `limit`.
[[nodiscard]] Error backlog_error(const Backlog& backlog, double limit);
[[nodiscard]] Error time_limit_error(std::chrono::milliseconds limit);

}  // namespace multitetra
