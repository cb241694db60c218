#include "server/routes/detail/surface_query.hpp"

#include <string_view>

#include "common/request/shared_budget.hpp"
#include "common/request/threshold_parser.hpp"
#include "server/routes/detail/query_parsers.hpp"

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

Objection set_isovalues(std::string_view text, SurfaceQuery& query) {
  const auto values = numbers_from(text, 1, kMaxSurfaces);
  if (!values) return "must be a number, or up to " + std::to_string(kMaxSurfaces) + " as A,B,C";
  query.isovalues = *values;
  return std::nullopt;
}

Objection set_min_component(std::string_view text, SurfaceQuery& query) {
  const auto diagonal = numbers_from(text, 1, 1);
  if (!diagonal || !(diagonal->front() >= 0)) return "must be a number of samples of at least 0";
  query.min_component = diagonal->front();
  return std::nullopt;
}

Objection set_color_range(std::string_view text, SurfaceQuery& query) {
  const auto ends = numbers_from(text, 2, 2);
  if (!ends) return "must be two numbers, LOW,HIGH";
  query.color_range = {ends->front(), ends->back()};
  return std::nullopt;
}

Objection set_color_by(std::string_view text, SurfaceQuery& query) {
  query.color_by = text;
  if (text.empty()) return "must be the name of a dataset";
  return std::nullopt;
}

const Setters<Q>& setters() {
  static const Setters<Q> kSetters = {
      {"isovalue", set_isovalues},
      {"color_by", set_color_by},
      {"color_range", set_color_range},
      {"colors", word<Q>(
                     [](Q & q) -> auto& { return q.colors.map; }, color_map_from,
                     std::string(kColorMapNames))},
      {"color_scale", word<Q>(
                          [](Q & q) -> auto& { return q.colors.is_logarithmic; },
                          is_logarithmic_from, "linear or log")},
      {"no_value",
       word<Q>(
           [](Q & q) -> auto& { return q.colors.no_value; }, rgb_from, "a colour, RRGGBB")},
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
      {"min_component", set_min_component},
      {"coordinates",
       word<Q>(
           [](Q & q) -> auto& { return q.is_in_world; }, is_world, "world or index")},
      {"format", word<Q>(
                     [](Q & q) -> auto& { return q.format; },
                     [](std::string_view text) { return mesh_format_from(text); },
                     "glb, ply, stl, obj, drc or vtp")}};
  return kSetters;
}

}  // namespace

Result<SurfaceQuery> parse_surface_query(
    const std::vector<std::pair<std::string, std::string>>& query) {
  return parse_query<SurfaceQuery>(query, setters(), "region");
}

Result<std::vector<IsosurfaceRequest>> requests_for(const SurfaceQuery& query,
                                                    const DatasetInfo& info) {
  if (query.isovalues.empty() && info.suggested_isovalues.empty()) {
    return fail(ErrorCode::kInvalidArgument,
                "Dataset \"" + info.name + "\" suggests no isovalue; name one with isovalue=.");
  }
  std::vector<double> isovalues = query.isovalues;
  if (isovalues.empty()) isovalues.push_back(info.suggested_isovalues.front());
  std::vector<IsosurfaceRequest> requests;
  for (const double isovalue : isovalues) {
    IsosurfaceRequest request = query.request;
    request.isovalue = isovalue;
    auto valid = validated(request);
    if (!valid) return tl::unexpected(valid.error());
    requests.push_back(*std::move(valid));
  }
  if (const auto shared = check_shared_budget(requests); !shared) {
    return tl::unexpected(shared.error());
  }
  return requests;
}

Result<std::optional<ScalarRequest>> scalars_for(const SurfaceQuery& query) {
  if (query.color_by.empty()) {
    if (!query.color_range && !query.colors.is_logarithmic) return std::nullopt;
    return fail(ErrorCode::kInvalidArgument,
                "color_range and color_scale need color_by, whose values they are of.");
  }
  if (query.colors.is_logarithmic && !(query.color_range && query.color_range->low > 0)) {
    return fail(ErrorCode::kInvalidArgument,
                "color_scale=log needs color_range=LOW,HIGH with both above 0.");
  }
  auto valid = validated(ScalarRequest{.dataset = query.color_by, .limits = query.color_range});
  if (!valid) return tl::unexpected(valid.error());
  return *std::move(valid);
}

}  // namespace multitetra
