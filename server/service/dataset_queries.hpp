// Requests about a dataset other than for surfaces. A worker answers each with one message.
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
// Returns the kind in one word for the log: "estimate", "slice" or "probe".
[[nodiscard]] const char* kind_of(const DatasetQuery& query);
// Returns the isosurface that an estimate is about; null for other queries.
[[nodiscard]] const IsosurfaceRequest* request_of(const DatasetQuery& query);
// Returns whether the answer may take as long as a step.
[[nodiscard]] bool is_long(const DatasetQuery& query);

// Answers a query. Requires a validated query of the source's dataset. Throws what the source
// throws, and Cancelled soon after `stop` is triggered.
[[nodiscard]] Result<DatasetQueryReply> answered(const SurfaceProvider& source,
                                                 const DatasetQuery& query,
                                                 const std::stop_token& stop);

}  // namespace multitetra
