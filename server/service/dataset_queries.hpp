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

[[nodiscard]] std::uint64_t request_id_of(const DatasetQuery& query);
[[nodiscard]] const std::string& dataset_of(const DatasetQuery& query);
[[nodiscard]] Priority priority_of(const DatasetQuery& query);
// In a word, for the log: "estimate", "slice", "probe".
[[nodiscard]] const char* kind_of(const DatasetQuery& query);
// The isosurface of the query, null for other queries.
[[nodiscard]] const IsosurfaceRequest* request_of(const DatasetQuery& query);
// Whether the answer may take as long as a step.
[[nodiscard]] bool is_long(const DatasetQuery& query);

// Requires a query of the source's dataset, validated. Throws what the source throws; Cancelled
// soon after `stop` is triggered.
[[nodiscard]] Result<DatasetQueryReply> answered(const SurfaceProvider& source,
                                                 const DatasetQuery& query,
                                                 const std::stop_token& stop);

}  // namespace multitetra
