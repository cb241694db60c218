// A query as a request for an isosurface: the words of the command line's options. Pure.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/result.hpp"
#include "common/request/dataset_info.hpp"
#include "common/request/isosurface_request.hpp"
#include "common/wire/mesh_files.hpp"

namespace multitetra {

struct SurfaceQuery {
  std::optional<double> isovalue;  // None: the dataset's first suggestion.
  IsosurfaceRequest request = {.error = 0.25, .simplify = true};  // Without its isovalue.
  bool is_in_world = true;           // The mesh's coordinates; else sample indices.
  std::optional<MeshFormat> format;  // None: what the client accepts.
};

// isovalue, error, unit, bound, topology_rule, topology_tolerance, lattice, region (repeatable),
// region_unit, view, combine, max_triangles, max_bytes, simplify, normals, coordinates,
// format.
// kInvalidArgument, naming the parameter, when one is unknown, said twice or not understood.
[[nodiscard]] Result<SurfaceQuery> parse_surface_query(
    const std::vector<std::pair<std::string, std::string>>& query);

// The request for a dataset, checked as one that came over the wire.
[[nodiscard]] Result<IsosurfaceRequest> request_for(const SurfaceQuery& query,
                                                    const DatasetInfo& info);

}  // namespace multitetra
