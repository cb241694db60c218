// Reports of a fetch, as JSON and as text.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/library/client.hpp"
#include "common/mesh/mesh_measures.hpp"
#include "common/wire/written_mesh.hpp"

namespace multitetra {

// One fetch: server, request and every step received.
struct FetchReport {
  Endpoint server;
  OpenStream open;
  std::vector<std::string> notices = {};  // Warnings about the request, one sentence each.
  std::string coordinates;                // "world" or "index"
  std::vector<double> shift = {};         // Added to them; empty: nothing.
  std::string mesh_file;                  // Empty when none was written.
  // All but the last may lack their meshes.
  std::vector<FetchedStep> steps;
  // What the mesh file holds; absent if none was written.
  std::optional<WrittenMesh> written = {};
  std::optional<std::uint64_t> components_written = {};
  std::optional<std::uint64_t> triangles_written = {};
  // The measures of the written components of the final step.
  std::optional<SurfaceMeasures> measures = {};
  std::optional<double> distance_bound = {};  // mesh_distance_bound() of the final step.
  std::string open_reason = {};               // Of the dataset, see json_report.hpp.
  // Triangles in the file that intersect others; nullopt: not counted.
  std::optional<std::uint64_t> self_intersecting_triangles = {};
  std::uint64_t tiles_held = 0;  // Cached from earlier fetches.
  ReceivedTiles received = {};   // Over all connections.
  int reconnections = 0;         // Retries after a lost connection.
  // The error that ended the fetch before its final step.
  std::optional<Error> error = std::nullopt;
};

// Returns the largest bound of all tiles, which is part of the error bound; 0 without
// simplification.
[[nodiscard]] double simplification_bound(const StepBegin& begin);

// Returns indented JSON that ends with a newline: server, dataset, parameters, notices, final_only,
// coordinates, mesh_file, components_written, triangles_written and written (json_report.hpp; null:
// no file was written), area and volume (of the written components, in world units; null: no final
// step, or the surface has a border), is_full_resolution (whether that step is the full-resolution
// surface), volume_reason (why there is no volume; null: there is one), volume_bound (the largest
// difference from the volume inside the full-resolution surface, see volume_bound(); null: no
// distance is bounded), self_intersecting_triangles (null: not counted), tiles_held,
// tiles_received, bytes_received, reconnections, steps and, for a failed fetch, error: {code,
// text}. A step has the keys of json_report.hpp and: step, final, parameters, error_bound_world
// (null for previews), finest_spacing, codec (draco, sample_shell), tetrahedra, active_tetrahedra,
// tiles, tiles_received, bytes (of payload), first_byte_seconds, seconds, server_seconds,
// content_digest, checks. After a lost connection, tiles_received and bytes of a step count from
// the reconnection.
[[nodiscard]] std::string json_report(const FetchReport& report);
// Returns the reports of several surfaces: {"surfaces": [...]}, each as above.
[[nodiscard]] std::string json_report(std::span<const FetchReport> reports);
[[nodiscard]] std::string json_list(const Endpoint& server,
                                    const std::vector<DatasetInfo>& datasets);

// Returns one line without a newline: "step 0 (preview): isovalue 500.5, spacing 4 samples, ...",
// "step 2 (final): isovalue 500.5, error 1 voxel, 34 tiles, 12 345 triangles, 18.2 KiB, 240 ms".
[[nodiscard]] std::string step_line(const FetchedStep& step, const DatasetInfo& info);
// Returns a table of the checks of all steps, one column per step.
[[nodiscard]] std::string checks_table(const std::vector<FetchedStep>& steps);
// Returns a table with one dataset per line.
[[nodiscard]] std::string text_list(const std::vector<DatasetInfo>& datasets);

}  // namespace multitetra
