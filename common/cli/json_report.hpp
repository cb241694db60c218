// The keys of our JSON reports, the same in the server's programs and the client's. Includes only
// declarations of <nlohmann/json.hpp>: include that to build a report.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "common/mesh/mesh_checks.hpp"
#include "common/mesh/mesh_measures.hpp"
#include "common/request/dataset_info.hpp"
#include "common/request/isosurface_request.hpp"

namespace multitetra {

using Json = nlohmann::ordered_json;

// isovalue, error, unit, bound, topology_rule, topology_tolerance, lattice; where they are not
// their defaults also thresholds, max_triangles, max_bytes, simplify, embedded, normals
[[nodiscard]] Json json_of(const IsosurfaceRequest& request);

// region_unit, combine, at_least, regions, threshold_grid (its samples as a summary), view; the
// latter three where there are any
[[nodiscard]] Json json_of(const LocalThresholds& thresholds);

// is_empty, triangles, vertices, euler_characteristic, components, border_edges, open_edges,
// nonmanifold_edges, degenerate_triangles
[[nodiscard]] Json json_of(const MeshTopology& topology);

// name, dims, type, spacing, min, max, void_samples, outside (null: void), margin, grid_exponent,
// index_to_world, space, length_unit, value_unit (null: unknown), suggested_isovalues, histogram
[[nodiscard]] Json json_of(const DatasetInfo& info);

// area (in the world), area_is_exact (whether the surface is the full-resolution one), volume
// (null: the surface has a border), volume_reason (why; null: it has one), volume_bound (how far
// the volume may be from that inside the full-resolution surface: area times `distance_bound`;
// null: no distance is bounded). All null without measures.
[[nodiscard]] Json json_of(const std::optional<SurfaceMeasures>& measures,
                           std::optional<double> distance_bound,
                           std::optional<bool> is_full_resolution);
// Advice where volume_bound is more than a tenth of the volume; else none.
[[nodiscard]] std::vector<std::string> volume_notice(const SurfaceMeasures& measures,
                                                     std::optional<double> distance_bound);

// Indented, with a newline at the end. Bytes that are no UTF-8, as in names from outside, are
// replaced.
[[nodiscard]] std::string text_of(const Json& json);

}  // namespace multitetra
