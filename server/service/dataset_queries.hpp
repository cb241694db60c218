// Requests about a dataset besides its surfaces, which are answered with one message by a worker.
#pragma once

#include <cstdint>
#include <stop_token>
#include <string>
#include <variant>

#include "common/wire/messages.hpp"
#include "server/stream/surface_provider.hpp"

namespace multitetra {

using DatasetQuery = std::variant<Estimate, Slice, Probe>;
using DatasetQueryReply = std::variant<EstimateReply, SliceReply, ProbeReply>;

[[nodiscard]] std::uint64_t request_id_of(const DatasetQuery& question);
[[nodiscard]] const std::string& dataset_of(const DatasetQuery& question);
[[nodiscard]] Priority priority_of(const DatasetQuery& question);
// In a word, for the log: "estimate", "slice", "probe".
[[nodiscard]] const char* kind_of(const DatasetQuery& question);
// The isosurface of the question, null for other questions.
[[nodiscard]] const IsosurfaceRequest* request_of(const DatasetQuery& question);
// Whether the answer may take as long as a step.
[[nodiscard]] bool is_long(const DatasetQuery& question);

// Requires a question of the source's dataset, validated. Throws what the source throws; Cancelled
// soon after `stop` is triggered.
[[nodiscard]] Result<DatasetQueryReply> answered(const SurfaceProvider& source,
                                                 const DatasetQuery& question,
                                                 const std::stop_token& stop);

}  // namespace multitetra
