#include "server/routes/detail/mesh_query.hpp"

#include "common/request/field_setters.hpp"

namespace multitetra {
namespace {

using Q = MeshQuery;

constexpr QueryField<Q> kFormat[] = {
    {"format", "glb|ply|stl|obj|drc|vtp|3mf", "",
     "Format of the file; default: the one in Accept, or glb. Positions have the unit and the axes "
     "of the dataset; the nodes of a glb rotate z up to glTF's y up and do not scale to metres. "
     "The node of a glb, a comment of a ply and the object of an obj name the dataset or label; "
     "the extras of the node and the first line also have the label's number",
     set_word<&Q::format, mesh_format_from>}};

Setters<Q> mesh_setters() {
  auto all = setters_of<Q>(
      request_fields(), [](Q & query) -> auto& { return query.surface; });
  all.merge(setters_of<Q>(file_fields(), [](Q& query) -> Q& { return query; }));
  return all;
}

}  // namespace

std::span<const QueryField<MeshQuery>> file_fields() { return kFormat; }

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
