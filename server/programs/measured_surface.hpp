// The measures that `extract` reports of a surface, alone or as one of a folder.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "common/cli/surface_options.hpp"
#include "common/json/json_report.hpp"
#include "common/mesh/mesh_checks.hpp"

namespace multitetra {

struct MeasuredSurface {
  MeshTopology topology = {};
  double simplification_bound = 0;  // World units.
  // Triangles in the file that intersect others. Only simplification can cause them; absent
  // without it.
  std::optional<std::size_t> self_intersecting = {};
  // The measures of the components in the file.
  std::optional<SurfaceMeasures> measures = {};
  // In world units, including the lattice; absent if unbounded.
  std::optional<double> distance_bound = {};
  bool is_full_resolution = false;
  std::string open_reason = {};  // See json_report.hpp.
};

// Adds area, volume and their bounds. `is_bounded` is whether the request's error bounds the
// distance from the full-resolution surface; requests with a topology tolerance or another measure
// are never bounded.
void measure(MeasuredSurface& surface, const LatticeMesh& mesh, const SurfaceArguments& arguments,
             const IsosurfaceRequest& request, const DatasetInfo& info, bool is_bounded = true);

// Keys: those of topology and measures, simplification_bound_world, self_intersecting_triangles if
// there is a number.
[[nodiscard]] Json json_of(const MeasuredSurface& surface);

}  // namespace multitetra
