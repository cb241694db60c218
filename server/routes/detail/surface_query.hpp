// A query as a request for an isosurface: the words of the command line's options. Pure.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/result.hpp"
#include "common/image/color_map.hpp"
#include "common/request/dataset_info.hpp"
#include "common/request/isosurface_request.hpp"
#include "common/request/scalar_request.hpp"
#include "common/wire/mesh_files.hpp"

namespace multitetra {

inline constexpr std::size_t kMaxSurfaces = 16;  // In one file.

struct SurfaceQuery {
  // A surface for each, at most kMaxSurfaces; none: the dataset's first suggestion.
  std::vector<double> isovalues = {};
  IsosurfaceRequest request = {.error = 0.25, .simplify = true};  // Without its isovalue.
  double min_component = 0;          // Samples of diagonal: shorter components are left out.
  bool is_in_world = true;           // The mesh's coordinates; else sample indices.
  std::optional<MeshFormat> format;  // None: what the client accepts.
  // The dataset whose values colour the surface; empty: none.
  std::string color_by = {};
  std::optional<ScalarRequest::Limits> color_range = {};
  ColorScale colors = {.map = ColorMap::kViridis};  // Without its ends, which the step tells.
};

// isovalue, error, unit, bound, topology_rule, topology_tolerance, lattice, region (repeatable),
// region_unit, view, combine, max_triangles, max_bytes, simplify, normals, min_component,
// coordinates, format, color_by, colors, color_range, color_scale, no_value.
// kInvalidArgument, naming the parameter, when one is unknown, said twice or not understood.
[[nodiscard]] Result<SurfaceQuery> parse_surface_query(
    const std::vector<std::pair<std::string, std::string>>& query);

// The requests for a dataset, one a surface, checked as those that came over the wire.
[[nodiscard]] Result<std::vector<IsosurfaceRequest>> requests_for(const SurfaceQuery& query,
                                                                  const DatasetInfo& info);

// What colours the surfaces, checked; nullopt: nothing.
[[nodiscard]] Result<std::optional<ScalarRequest>> scalars_for(const SurfaceQuery& query);

}  // namespace multitetra
