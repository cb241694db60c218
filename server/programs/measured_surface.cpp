#include "server/programs/measured_surface.hpp"

#include "common/base/json.hpp"
#include "common/dataset/dataset_info.hpp"
#include "server/core/thresholds/threshold_map.hpp"

namespace multitetra {

void measure(MeasuredSurface& surface, const LatticeMesh& mesh, const SurfaceArguments& arguments,
             const IsosurfaceRequest& request, const DatasetInfo& info, bool is_bounded) {
  surface.open_reason = open_reason(info);
  surface.measures = measures_from(mesh, arguments.query.min_component, grid_to_world(info));
  is_bounded = is_bounded && request.topology_tolerance == 0 &&
               request.error_measure == ErrorMeasure::kCertified;
  if (!is_bounded) return;
  const double error = largest_threshold(request, info);
  surface.distance_bound = error + lattice_rounding_world(info, request.lattice_resolution);
  surface.is_full_resolution = error == 0;
}

Json json_of(const MeasuredSurface& surface) {
  Json report = json_of(surface.topology);
  report["simplification_bound_world"] = surface.simplification_bound;
  report.update(json_of(surface.measures, surface.distance_bound, surface.is_full_resolution,
                        surface.open_reason));
  if (surface.self_intersecting) {
    report["self_intersecting_triangles"] = *surface.self_intersecting;
  }
  return report;
}

}  // namespace multitetra
