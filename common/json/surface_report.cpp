#include "common/json/surface_report.hpp"

#include "common/base/json.hpp"

namespace multitetra {
namespace {

Json json_of(const WholeSurface& surface) {
  Json json = multitetra::json_of(surface.topology);
  json["tetrahedra"] = surface.tetrahedra;
  json["active_tetrahedra"] = surface.active_tetrahedra;
  json["tiles"] = surface.tiles;
  json["error_bound_world"] = value_or_null(surface.error_bound);
  json["simplification_bound_world"] = surface.simplification_bound;
  json["content_digest"] = surface.digest.hex();
  return json;
}

}  // namespace

Json json_of(const SurfaceReport& report) {
  Json json = {{"dataset", report.dataset}, {"name", report.name.text}};
  if (report.name.label) json["label"] = *report.name.label;
  json["parameters"] = json_of(report.request);
  json["notices"] = report.notices;
  json["coordinates"] = report.coordinates;
  if (!report.shift.empty()) json["shift"] = report.shift;
  if (!report.color_by.empty()) json["color_by"] = report.color_by;
  if (report.colors) json["color_range"] = {report.colors->low, report.colors->high};
  if (report.surface) json.update(json_of(*report.surface));
  std::optional<bool> is_full_resolution;
  if (report.surface && report.measures) is_full_resolution = report.surface->error_bound == 0.0;
  json.update(
      json_of(report.measures, report.distance_bound, is_full_resolution, report.open_reason));
  std::optional<std::uint64_t> self_intersecting;
  if (report.written && report.written->self_intersections) {
    self_intersecting = report.written->self_intersections->triangles;
  }
  json["self_intersecting_triangles"] = value_or_null(self_intersecting);
  json["mesh_file"] = report.mesh_file.empty() ? Json(nullptr) : Json(report.mesh_file);
  json["components_written"] = value_or_null(report.components_written);
  json["triangles_written"] = value_or_null(report.triangles_written);
  json["written"] = report.written ? json_of(*report.written) : Json(nullptr);
  json.update(report.more);
  return json;
}

}  // namespace multitetra
