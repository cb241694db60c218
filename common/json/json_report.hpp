// The keys of our JSON reports, shared by server and client programs. Includes only the forward
// declarations of <nlohmann/json.hpp>; include that to build a report.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "common/base/json.hpp"
#include "common/dataset/dataset_info.hpp"
#include "common/mesh/mesh_checks.hpp"
#include "common/mesh/mesh_measures.hpp"
#include "common/request/isosurface_request.hpp"
#include "common/wire/written_mesh.hpp"

namespace multitetra {

using Json = nlohmann::ordered_json;

// `Value` is bool, double or std::uint64_t.
template <typename Value>
[[nodiscard]] Json value_or_null(const std::optional<Value>& value);

// Keys: isovalue, error, unit, bound, topology_rule, topology_tolerance, lattice, simplify; if they
// differ from their defaults also thresholds, max_triangles, max_bytes, intersection_free, normals.
[[nodiscard]] Json json_of(const IsosurfaceRequest& request);

// Keys: region_coordinates, combine, at_least; if present regions, threshold_grid (a summary) and
// view.
[[nodiscard]] Json json_of(const LocalThresholds& thresholds);

// Keys: is_empty, triangles, vertices, euler_characteristic, components, border_edges, open_edges,
// nonmanifold_edges, degenerate_triangles.
[[nodiscard]] Json json_of(const MeshTopology& topology);

// Keys: triangles, vertices, euler_characteristic, components, closed, open_edges (all of a single
// triangle), nonmanifold_edges, degenerate_triangles, flat_triangles (null: not counted).
[[nodiscard]] Json json_of(const WrittenMesh& written);

// Keys: the fields of common/dataset/dataset_fields.hpp.
[[nodiscard]] Json json_of(const DatasetInfo& info);

// Keys: area (of the components in the file, in world units; that of the full-resolution surface
// only if is_full_resolution, as no distance bounds the difference), is_full_resolution, volume
// (null: the surface has a border), volume_reason (the reason for that, with open_reason(); else
// null), volume_bound (the largest difference from the volume of the full-resolution surface: see
// volume_bound() in mesh_measures.hpp; null without a bound). All null without measures.
[[nodiscard]] Json json_of(const std::optional<SurfaceMeasures>& measures,
                           std::optional<double> distance_bound,
                           std::optional<bool> is_full_resolution, const std::string& open_reason);
// Returns where surfaces of the data may be open, and what closes them: "at the border of the data;
// `prepare` with --pad-value VALUE --pad 1 closes it".
[[nodiscard]] std::string open_reason(const DatasetInfo& info);
// Returns advice if volume_bound exceeds a fiftieth of the volume.
[[nodiscard]] std::vector<std::string> volume_notice(const SurfaceMeasures& measures,
                                                     std::optional<double> distance_bound);

// Returns indented text that ends with a newline. Replaces invalid UTF-8, as in names from outside.
[[nodiscard]] std::string text_of(const Json& json);

}  // namespace multitetra
