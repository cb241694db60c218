#include "common/json/json_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "common/base/json.hpp"
#include "common/dataset/dataset_fields.hpp"

namespace multitetra {

namespace {

Json text_or_null(std::string_view text) { return text.empty() ? Json(nullptr) : Json(text); }

Json json_of(const BoxShape& box) { return {{"low", box.low}, {"high", box.high}}; }
Json json_of(const BallShape& ball) { return {{"center", ball.center}, {"radius", ball.radius}}; }
Json json_of(const HalfSpaceShape& half_space) {
  return {{"normal", half_space.normal}, {"offset", half_space.offset}};
}

constexpr const char* kShapeNames[] = {"box", "ball", "halfspace"};

Json json_of(const ThresholdRegion& region) {
  return {{"threshold", region.threshold},
          {kShapeNames[region.shape.index()],
           std::visit([](const auto& shape) { return json_of(shape); }, region.shape)}};
}

Json json_of(const Affine& map) {
  return {{"columns", map.columns}, {"translation", map.translation}};
}

Json json_of(const ThresholdGrid& grid) {
  float least = std::numeric_limits<float>::infinity();
  float largest = -least;
  std::size_t silent = 0;
  for (const float threshold : grid.thresholds) {
    silent += std::isnan(threshold);
    least = std::min(least, threshold);  // Ignores NaN.
    largest = std::max(largest, threshold);
  }
  const bool is_silent = silent == grid.thresholds.size();
  return {{"dims", grid.dims},
          {"index_to_world", json_of(grid.index_to_world)},
          {"least", is_silent ? Json(nullptr) : Json(least)},
          {"largest", is_silent ? Json(nullptr) : Json(largest)},
          {"samples_without", silent}};
}

Json json_of(const ThresholdView& view) {
  Json json = {{"eye", view.eye},
               {"field_of_view", view.field_of_view},
               {"height_pixels", view.height_pixels},
               {"tolerance_pixels", view.tolerance_pixels}};
  if (view.frustum) {
    json["frustum"] = {{"look_at", view.frustum->look_at},
                       {"up", view.frustum->up},
                       {"aspect", view.frustum->aspect},
                       {"outside", view.frustum->outside}};
  }
  return json;
}

}  // namespace

template <typename Value>
Json value_or_null(const std::optional<Value>& value) {
  return value ? Json(*value) : Json(nullptr);
}
template Json value_or_null(const std::optional<bool>&);
template Json value_or_null(const std::optional<double>&);
template Json value_or_null(const std::optional<std::uint64_t>&);

Json json_of(const LocalThresholds& thresholds) {
  Json json = {{"region_coordinates", name(thresholds.coordinates)},
               {"combine", name(thresholds.combination)},
               {"at_least", thresholds.error_floor}};
  for (const ThresholdRegion& region : thresholds.regions) {
    json["regions"].push_back(json_of(region));
  }
  if (thresholds.grid) json["threshold_grid"] = json_of(*thresholds.grid);
  if (thresholds.view) json["view"] = json_of(*thresholds.view);
  return json;
}

Json json_of(const IsosurfaceRequest& request) {
  Json json = {{"isovalue", request.isovalue},
               {"error", request.error},
               {"unit", name(request.unit)},
               {"bound", name(request.error_measure)},
               {"topology_rule", name(request.topology_rule)},
               {"topology_tolerance", request.topology_tolerance},
               {"lattice", request.lattice_resolution},
               {"simplify", request.simplify}};
  if (request.thresholds != LocalThresholds{}) json["thresholds"] = json_of(request.thresholds);
  if (request.max_triangles != 0) json["max_triangles"] = request.max_triangles;
  if (request.max_bytes != 0) json["max_bytes"] = request.max_bytes;
  if (request.intersection_free) json["intersection_free"] = true;
  if (request.normal_bits != 0) json["normals"] = request.normal_bits;
  return json;
}

Json json_of(const MeshTopology& topology) {
  return {{"is_empty", topology.triangles == 0},
          {"triangles", topology.triangles},
          {"vertices", topology.vertices},
          {"euler_characteristic", topology.euler_characteristic},
          {"components", topology.components},
          {"border_edges", topology.border_edges},
          {"open_edges", topology.open_edges},
          {"nonmanifold_edges", topology.nonmanifold_edges},
          {"degenerate_triangles", topology.degenerate_triangles}};
}

Json json_of(const WrittenMesh& written) {
  const MeshTopology& found = written.topology;
  const auto& crossing = written.self_intersections;
  return {{"triangles", found.triangles},
          {"vertices", found.vertices},
          {"euler_characteristic", found.euler_characteristic},
          {"components", found.components},
          {"closed", written.is_closed()},
          {"open_edges", found.border_edges},
          {"nonmanifold_edges", found.nonmanifold_edges},
          {"degenerate_triangles", found.degenerate_triangles},
          {"flat_triangles", crossing ? Json(crossing->flat_triangles) : Json(nullptr)}};
}

Json json_of(const SeriesMember& member) {
  Json label;
  if (member.label) {
    label = {{"value", member.label->value},
             {"name", member.label->name},
             {"color", member.label->color ? Json(color_text(*member.label->color)) : Json()}};
  }
  return {{"series", member.series},
          {"field", member.field},
          {"time", value_or_null(member.time)},
          {"time_unit", member.time_unit},
          {"color", member.color ? Json(color_text(*member.color)) : Json()},
          {"label", label}};
}

namespace {

// Samples, box and centroid of a label are null if unknown.
void add_extent(Json& label, const std::optional<LabelExtent>& extent) {
  const bool has_place = extent && extent->place;
  label["samples"] = extent ? Json(extent->samples) : Json();
  label["box"] = has_place ? Json({extent->place->least, extent->place->greatest}) : Json();
  label["centroid"] = has_place ? Json(extent->place->centroid) : Json();
}

// The values of fields of DatasetInfo; null: none, unknown.
template <typename Value>
Json field_json(const Value& value) {
  return value;
}
Json field_json(const std::string& text) { return text_or_null(text); }
Json field_json(SampleType type) { return name(type); }
Json field_json(WorldSpace space) { return text_or_null(name(space)); }
Json field_json(GeometryBasis basis) { return text_or_null(name(basis)); }
Json field_json(const Affine& map) { return json_of(map); }
Json field_json(const std::optional<double>& value) { return value_or_null(value); }
Json field_json(const std::optional<SeriesMember>& member) {
  return member ? json_of(*member) : Json();
}
Json field_json(const std::optional<DisplayWindow>& window) {
  return window ? Json::array({window->low, window->high}) : Json();
}
Json field_json(const Histogram& histogram) {
  return {{"low", histogram.low}, {"high", histogram.high}, {"counts", histogram.counts}};
}

}  // namespace

Json json_of(const DatasetInfo& info) {
  Json json;
  visit_dataset_fields(info, [&json](const DatasetField& field, const auto& value) {
    json[field.name] = field_json(value);
  });
  if (info.member && info.member->label) add_extent(json["member"]["label"], info.label_extent);
  return json;
}

namespace {

std::optional<double> volume_bound(const SurfaceMeasures& measures,
                                   std::optional<double> distance_bound) {
  if (!measures.volume || !distance_bound) return std::nullopt;
  return multitetra::volume_bound(measures, *distance_bound);
}

}  // namespace

Json json_of(const std::optional<SurfaceMeasures>& measures, std::optional<double> distance_bound,
             std::optional<bool> is_full_resolution, const std::string& open_reason) {
  if (!measures) {
    return {{"area", nullptr},
            {"is_full_resolution", nullptr},
            {"volume", nullptr},
            {"volume_reason", nullptr},
            {"volume_bound", nullptr}};
  }
  const Json reason = measures->volume ? Json(nullptr) : Json("the surface is open " + open_reason);
  return {{"area", measures->area},
          {"is_full_resolution", value_or_null(is_full_resolution)},
          {"volume", value_or_null(measures->volume)},
          {"volume_reason", reason},
          {"volume_bound", value_or_null(volume_bound(*measures, distance_bound))}};
}

std::string open_reason(const DatasetInfo& info) {
  const bool is_closed_at_border = info.outside && info.margin > 0;
  const std::string void_samples =
      "at void samples of the data (NaN, or missing: " + std::to_string(info.void_samples) + ")";
  if (is_closed_at_border) {
    return void_samples + ", which --pad-value does not fill; give them a value in the volume";
  }
  return std::string("at the border of the data") +
         (info.void_samples > 0 ? " or " + void_samples : "") +
         "; `prepare` with --pad-value VALUE --pad 1 closes it" +
         (info.void_samples > 0 ? " at the border" : "");
}

std::vector<std::string> volume_notice(const SurfaceMeasures& measures,
                                       std::optional<double> distance_bound) {
  constexpr double kWide = 0.02;
  const auto bound = volume_bound(measures, distance_bound);
  if (!bound || *bound <= kWide * std::abs(*measures.volume)) return {};
  const double percent = 100 * *bound / std::abs(*measures.volume);
  const std::string part =
      std::isfinite(percent) ? std::to_string(std::llround(percent)) + " % of" : "more than";
  return {"volume_bound is " + part +
          " the volume; to quote the volume use --error 0 --lattice 8, which narrows it most."};
}

std::string text_of(const Json& json) { return json_text(json, 2) + "\n"; }

}  // namespace multitetra
