// Parses a query for a mesh file: the fields of common/request/surface_query.hpp, and the file's
// format. Pure.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/base/result.hpp"
#include "common/request/surface_query.hpp"
#include "common/wire/mesh_files.hpp"
#include "server/routes/detail/query_parsers.hpp"

namespace multitetra {

inline constexpr std::size_t kMaxSurfaces = 16;  // Per file.

struct MeshQuery {
  SurfaceQuery surface = {};
  std::optional<MeshFormat> format = {};  // None: chosen by the Accept header.
};

// Returns the fields besides those of surface_query.hpp.
[[nodiscard]] std::span<const QueryField<MeshQuery>> file_fields();

// Returns kInvalidArgument, naming the parameter, if one is unknown, repeated or invalid, or if
// there are more than kMaxSurfaces isovalues.
[[nodiscard]] Result<MeshQuery> parse_mesh_query(
    const std::vector<std::pair<std::string, std::string>>& query);

}  // namespace multitetra
