// Reports of a fetch, as JSON and as text.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/library/client.hpp"
#include "common/json/surface_report.hpp"

namespace multitetra {

// One fetch: server, request and every step received.
struct FetchReport {
  Endpoint server;
  OpenStream open;
  // All but the last may lack their meshes.
  std::vector<FetchedStep> steps;
  SurfaceReport surface = {};    // Of the final step; it needs no `surface` if there is one.
  std::uint64_t tiles_held = 0;  // Cached from earlier fetches.
  ReceivedTiles received = {};   // Over all connections.
  int reconnections = 0;         // Retries after a lost connection.
  // The error that ended the fetch before its final step.
  std::optional<Error> error = std::nullopt;
};

// Returns what is known of the surface of a step.
[[nodiscard]] WholeSurface whole_surface(const CommittedStep& step);

// Returns the largest bound of all tiles, which is part of the error bound; 0 without
// simplification.
[[nodiscard]] double simplification_bound(const StepBegin& begin);

// Returns the keys of surface_report.hpp and: server, final_only, tiles_held, tiles_received,
// bytes_received, reconnections, steps and, for a failed fetch, error: {code, text}. A step has the
// keys of json_report.hpp and: step, final, parameters, error_bound_world (null for previews),
// simplification_bound_world, finest_spacing, codec (draco, sample_shell), tetrahedra,
// active_tetrahedra, tiles, tiles_received, bytes (of payload), first_byte_seconds, seconds,
// server_seconds, content_digest, checks. After a lost connection, tiles_received and bytes of a
// step count from the reconnection.
[[nodiscard]] Json json_of(const FetchReport& report);
[[nodiscard]] std::string json_list(const Endpoint& server,
                                    const std::vector<DatasetInfo>& datasets);

// Returns one line without a newline: "step 0 (preview): isovalue 500.5, spacing 4 samples, ...",
// "step 2 (final): isovalue 500.5, error 1 voxel, 34 tiles, 12 345 triangles, 18.2 KiB, 240 ms".
[[nodiscard]] std::string step_line(const FetchedStep& step, const DatasetInfo& info);
// Returns a table of the checks of all steps, one column per step.
[[nodiscard]] std::string checks_table(const std::vector<FetchedStep>& steps);
// Returns a table with one dataset per line; a series has one line, at its first member. With the
// name of a series, one line for each of its members.
[[nodiscard]] std::string text_list(const std::vector<DatasetInfo>& datasets,
                                    const std::string& series = {});

}  // namespace multitetra
