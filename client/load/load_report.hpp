// The result of a load test, as JSON and as a table.
#pragma once

#include <string>

#include "client/load/load_run.hpp"

namespace multitetra {

// Returns indented JSON that ends with a newline: server, script, clients, idle, threads,
// duration_seconds, seed, streams {started, complete, replaced, failed, unfinished, retried},
// steps, tiles, tiles_sent_twice, payload_bytes, seconds_until_last_tile, wire_bytes, connections
// {welcomed, lost, failed_attempts, clients_without}, errors {CODE: {count, example}}, checks
// {streams_in_full, tiles_decoded, steps_compared, failed, texts} and seconds {connect, first_tile,
// first_step, last_tile, whole}: {count, mean, p50, p90, p99, max}.
[[nodiscard]] std::string json_report(const LoadOptions& options, const LoadStatistics& statistics);
[[nodiscard]] std::string table(const LoadStatistics& statistics);

[[nodiscard]] std::string json_report(const LoadOptions& options, Misbehaviour kind,
                                      const MisbehaviourCounts& counts);
[[nodiscard]] std::string table(Misbehaviour kind, const MisbehaviourCounts& counts);

}  // namespace multitetra
