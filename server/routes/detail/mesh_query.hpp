// A query as a request for a file with meshes: the fields of common/request/surface_query.hpp, and
// the file's format. Pure.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/result.hpp"
#include "common/request/surface_query.hpp"
#include "common/wire/mesh_files.hpp"

namespace multitetra {

inline constexpr std::size_t kMaxSurfaces = 16;  // In one file.

struct MeshQuery {
  SurfaceQuery surface = {};
  std::optional<MeshFormat> format = {};  // None: what the client accepts.
};

// kInvalidArgument, naming the parameter, when one is unknown, given twice or not understood, or
// there are more than kMaxSurfaces isovalues.
[[nodiscard]] Result<MeshQuery> parse_mesh_query(
    const std::vector<std::pair<std::string, std::string>>& query);

}  // namespace multitetra
