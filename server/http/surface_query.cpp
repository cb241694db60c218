#include "server/http/surface_query.hpp"

#include <string_view>

#include "common/request/threshold_words.hpp"
#include "server/http/query_words.hpp"

namespace multitetra {
namespace {

using Q = SurfaceQuery;

std::optional<bool> is_world(std::string_view text) {
  if (text == "world") return true;
  if (text == "index") return false;
  return std::nullopt;
}

std::optional<bool> is_on(std::string_view text) {
  if (text == "on") return true;
  if (text == "off") return false;
  return std::nullopt;
}

Objection add_region(std::string_view text, SurfaceQuery& query) {
  const auto region = parse_region(text);
  if (!region) return region.error().text;
  query.request.thresholds.regions.push_back(*region);
  return std::nullopt;
}

Objection set_view(std::string_view text, SurfaceQuery& query) {
  const auto view = parse_view(text);
  if (!view) return view.error().text;
  query.request.thresholds.view = *view;
  return std::nullopt;
}

Objection set_isovalue(std::string_view text, SurfaceQuery& query) {
  query.isovalue = number_from<double>(text);
  if (!query.isovalue) return "is no number";
  return std::nullopt;
}

const Setters<Q>& setters() {
  static const Setters<Q> kSetters = {
      {"isovalue", set_isovalue},
      {"error", number<Q>([](Q & q) -> auto& { return q.request.error; })},
      {"unit",
       word<Q>(
           [](Q & q) -> auto& { return q.request.unit; }, length_unit_from, "voxel or world")},
      {"bound", word<Q>(
                    [](Q & q) -> auto& { return q.request.measure; }, error_measure_from,
                    "certified or paper")},
      {"topology_rule", word<Q>(
                            [](Q & q) -> auto& { return q.request.topology_rule; },
                            topology_rule_from, "exact or paper")},
      {"topology_tolerance",
       number<Q>([](Q & q) -> auto& { return q.request.topology_tolerance; })},
      {"lattice", number<Q>([](Q & q) -> auto& { return q.request.lattice_resolution; })},
      {"region", add_region},
      {"region_unit", word<Q>(
                          [](Q & q) -> auto& { return q.request.thresholds.coordinates; },
                          coordinate_system_from, "world or index")},
      {"view", set_view},
      {"combine", word<Q>(
                      [](Q & q) -> auto& { return q.request.thresholds.combination; },
                      combination_from, "order or minimum")},
      {"max_triangles", number<Q>([](Q & q) -> auto& { return q.request.max_triangles; })},
      {"max_bytes", number<Q>([](Q & q) -> auto& { return q.request.max_bytes; })},
      {"simplify", word<Q>(
                       [](Q & q) -> auto& { return q.request.simplify; }, is_on, "on or off")},
      {"normals", number<Q>([](Q & q) -> auto& { return q.request.normal_bits; })},
      {"coordinates",
       word<Q>(
           [](Q & q) -> auto& { return q.is_in_world; }, is_world, "world or index")},
      {"format", word<Q>(
                     [](Q & q) -> auto& { return q.format; },
                     [](std::string_view text) { return mesh_format_from(text); },
                     "glb, ply, stl, obj or drc")}};
  return kSetters;
}

}  // namespace

Result<SurfaceQuery> parse_surface_query(
    const std::vector<std::pair<std::string, std::string>>& query) {
  return parse_query<SurfaceQuery>(query, setters(), "region");
}

Result<IsosurfaceRequest> request_for(const SurfaceQuery& query, const DatasetInfo& info) {
  if (!query.isovalue && info.suggested_isovalues.empty()) {
    return fail(ErrorCode::kInvalidArgument,
                "Dataset \"" + info.name + "\" suggests no isovalue; name one with isovalue=.");
  }
  IsosurfaceRequest request = query.request;
  request.isovalue = query.isovalue ? *query.isovalue : info.suggested_isovalues.front();
  return validated(request);
}

}  // namespace multitetra
