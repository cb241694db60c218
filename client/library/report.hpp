// Reports of a fetch, as JSON for programs and as text for people.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/library/client.hpp"
#include "common/mesh/mesh_measures.hpp"

namespace multitetra {

// A whole fetch: server, request, and every step received.
struct FetchReport {
  Endpoint server;
  OpenStream open;
  std::vector<std::string> notices = {};  // Warnings about the request, a sentence each.
  std::string coordinates;                // "world" or "index"
  std::string mesh_file;                  // Empty when none was written.
  std::vector<FetchedStep> steps;         // Meshes may be left out of all but the last.
  std::optional<std::uint64_t> components_written = {};  // In the mesh file.
  // For the components of the final step that are written.
  std::optional<SurfaceMeasures> measures = {};
  std::optional<double> distance_bound = {};  // mesh_distance_bound() of the final step.
  // Triangles of the final step that intersect others; nullopt: not counted.
  std::optional<std::uint64_t> self_intersecting_triangles = {};
  std::uint64_t tiles_held = 0;  // Before the fetch, from earlier ones.
  ReceivedTiles received = {};   // Over all connections.
  int reconnections = 0;         // How often a lost connection was tried again.
  std::optional<Error> error =
      std::nullopt;  // The error that ended the fetch before its final step.
};

// Indented JSON with a newline at its end: server, dataset, parameters, notices, final_only,
// coordinates, mesh_file and components_written (null: none was written), area and volume (in the
// world, of the components that are written; null: there is no final step, or it has a border),
// area_is_exact (whether that step is the full-resolution surface), volume_reason (why it has no
// volume; null: it has one), volume_bound (how far that volume may be from that inside the
// full-resolution surface: area times the bound of the distance; null: no distance is bounded),
// self_intersecting_triangles (null: not counted), tiles_held, tiles_received, bytes_received,
// reconnections, steps, and, of a fetch that failed, error: {code, text}. A step's keys are those
// of json_report.hpp and: step, final, parameters, error_bound_world (null: a preview has none),
// finest_spacing, codec (draco, sample_shell), tetrahedra, active_tetrahedra, tiles,
// tiles_received, bytes (of payload), first_byte_seconds, seconds, server_seconds, content_digest,
// checks. After a lost connection tiles_received and bytes of a step are those that came since.
[[nodiscard]] std::string json_report(const FetchReport& report);
// Several surfaces: {"surfaces": [...]}, each as above.
[[nodiscard]] std::string json_report(std::span<const FetchReport> reports);
[[nodiscard]] std::string json_list(const Endpoint& server,
                                    const std::vector<DatasetInfo>& datasets);

// One line without newline: "step 0 (preview): isovalue 500.5, spacing 4 samples, ...", "step 2
// (final): isovalue 500.5, error 1 voxel, 34 tiles, 12 345 triangles, 18.2 KiB, 240 ms".
[[nodiscard]] std::string step_line(const FetchedStep& step, const DatasetInfo& info);
// A table of the checks of every step, one column a step.
[[nodiscard]] std::string checks_table(const std::vector<FetchedStep>& steps);
// A table, one dataset a line.
[[nodiscard]] std::string text_list(const std::vector<DatasetInfo>& datasets);

}  // namespace multitetra
