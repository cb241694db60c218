#include "server/routes/detail/mesh_query.hpp"

#include "server/routes/detail/query_parsers.hpp"

namespace multitetra {
namespace {

using Q = MeshQuery;

Setters<Q> mesh_setters() {
  auto all = setters_of<Q>(
      request_fields(), [](Q & query) -> auto& { return query.surface; });
  all["format"] = {.set = [](std::string_view text, Q& query) -> FieldError {
    query.format = mesh_format_from(text);
    if (!query.format) return "must be glb, ply, stl, obj, drc or vtp";
    return std::nullopt;
  }};
  return all;
}

}  // namespace

Result<MeshQuery> parse_mesh_query(const std::vector<std::pair<std::string, std::string>>& query) {
  static const Setters<Q> kSetters = mesh_setters();
  auto parsed = parse_query<Q>(query, kSetters);
  if (parsed && parsed->surface.isovalues.size() > kMaxSurfaces) {
    return fail(ErrorCode::kInvalidArgument,
                "One file may have at most " + std::to_string(kMaxSurfaces) +
                    " surfaces; isovalue has " + std::to_string(parsed->surface.isovalues.size()) +
                    ".");
  }
  return parsed;
}

}  // namespace multitetra
