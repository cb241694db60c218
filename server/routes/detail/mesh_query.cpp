#include "server/routes/detail/mesh_query.hpp"

#include "server/routes/detail/query_parsers.hpp"

namespace multitetra {
namespace {

using Q = MeshQuery;

Setters<Q> setters() {
  Setters<Q> all = {{"format", word<Q>(
                                   [](Q & q) -> auto& { return q.format; },
                                   [](std::string_view text) { return mesh_format_from(text); },
                                   "glb, ply, stl, obj, drc or vtp")}};
  for (const RequestField& field : request_fields()) {
    all.emplace(field.name, Setter<Q>{.set =
                                          [&field](std::string_view text, Q& query) {
                                            return field.set(field, text, query.surface);
                                          },
                                      .is_repeatable = field.is_repeatable});
  }
  return all;
}

}  // namespace

Result<MeshQuery> parse_mesh_query(const std::vector<std::pair<std::string, std::string>>& query) {
  static const Setters<Q> kSetters = setters();
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
