// The workers' jobs for the service of this process, with estimates of their time. Nothing here
// throws: the client receives a general error, and the log has the cause.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>

#include "server/service/permit.hpp"
#include "server/service/surface.hpp"
#include "server/service/workers.hpp"
#include "server/stream/stream_plan.hpp"

namespace multitetra {

// Kinds of work that take about as long each time, and whether that is long, as far as is known at
// once.
struct WorkKind {
  std::string kind;
  bool is_long = false;
};
[[nodiscard]] WorkKind work_for(const SurfaceProvider& source, const StreamState& state);
[[nodiscard]] WorkKind work_for(const SurfaceProvider& source, const DatasetQuery& query);

// For a step that may be long: what the final step takes, from the spectrum alone, where that need
// not be fetched. None for a cell, which is small, nor within a budget, which many steps may be
// made for.
[[nodiscard]] Forecast forecast_for(const WorkKind& work, const StartStream& action,
                                    std::stop_token stop);

// The range of the codes of a stream's scalars, if it has any.
[[nodiscard]] std::optional<ScalarRange> range_of(const StartStream& action);

// The next step of a stream, with its scalars.
[[nodiscard]] Result<StepResult> make_step(const StartStream& action, const StreamState& state,
                                           const StepLimits& limits, const std::stop_token& stop);
// The final surface of a request. kLimitExceeded for one of more than `max_triangles`.
[[nodiscard]] Result<Surface> make_mesh(const StartStream& action, std::uint64_t max_triangles,
                                        StepLimits limits, const std::stop_token& stop);
[[nodiscard]] Result<DatasetQueryReply> make_answer(const RunQuery& action,
                                                    const std::stop_token& stop);

// The error for a client that has requested more than `limit` seconds of work already, or for
// something that takes too long.
[[nodiscard]] Error come_again(const Backlog& backlog, double limit);
[[nodiscard]] Error too_long(std::chrono::milliseconds limit);

}  // namespace multitetra
