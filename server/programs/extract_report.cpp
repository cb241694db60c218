#include "server/programs/extract_report.hpp"

#include <algorithm>
#include <cstdint>
#include <iostream>

#include <nlohmann/json.hpp>

#include "common/base/number_text.hpp"
#include "common/cli/human_units.hpp"
#include "common/cli/output_files.hpp"
#include "server/core/thresholds/threshold_map.hpp"

namespace multitetra {
namespace {

// Returns the largest bound of all tiles.
double simplification_bound(const TiledSurface& surface) {
  double bound = 0;
  for (const TileMesh& tile : surface.tiles) bound = std::max(bound, tile.simplification_bound);
  return bound;
}

}  // namespace

void add_measures(ExtractResult& result, const ExtractArguments& arguments, const LatticeMesh& mesh,
                  const DatasetInfo& info) {
  const IsosurfaceRequest& request = result.request;
  result.measures = measures_from(mesh, arguments.surface.query.min_component, grid_to_world(info));
  const bool is_bounded = !arguments.level && request.topology_tolerance == 0 &&
                          request.measure == ErrorMeasure::kCertified;
  if (!is_bounded) return;
  const double error = largest_threshold(request, info);
  // Rounding moves a vertex by at most half the diagonal of a lattice cell.
  result.distance_bound = error + lattice_step_world(info, request.lattice_resolution) / 2;
  result.is_full_resolution = error == 0;
}

Json json_of(const ExtractResult& result, const ExtractArguments& arguments,
             const std::vector<std::string>& notices, const Json& seconds) {
  Json report = {{"tetrahedra", result.surface.tetrahedra},
                 {"active_tetrahedra", result.surface.active_tetrahedra}};
  report.update(json_of(result.topology));
  report["tiles"] = result.surface.tiles.size();
  report["simplification_bound_world"] = simplification_bound(result.surface);
  report.update(json_of(result.measures, result.distance_bound, result.is_full_resolution));
  if (result.self_intersecting) report["self_intersecting_triangles"] = *result.self_intersecting;
  report["content_digest"] = result.content.hex();
  report["seconds"] = seconds;
  report["parameters"] = json_of(result.request);
  report["parameters"]["coordinates"] = name(arguments.surface.query.coordinates);
  report["parameters"]["errors"] = arguments.errors;
  if (arguments.level) report["parameters"]["level"] = *arguments.level;
  report["notices"] = notices;
  report["mesh_file"] = nullptr;
  return report;
}

void add_files(Json& report, const ExtractResult& result, const ExtractArguments& arguments,
               const OutputSurface& written) {
  report["mesh_file"] = arguments.output;
  report["components_written"] = written.components;
  report["triangles_written"] = written.mesh.triangles.size();
  if (!result.model) return;
  report["model"] = {{"file", result.model->file},
                     {"scope", arguments.model_scope},
                     {"tetrahedra", result.model->tetrahedra},
                     {"points", result.model->points}};
}

void write_report(const Json& report, const ExtractArguments& arguments) {
  if (!arguments.report.empty()) write_file(arguments.report, text_of(report));
  if (arguments.json) std::cout << text_of(report);
}

void print_result(const ExtractResult& result, const ExtractArguments& arguments,
                  const OutputSurface& written) {
  const MeshTopology& topology = result.topology;
  std::cout << arguments.output << ": "
            << "isovalue " << shortest_text(result.request.isovalue) << ", "
            << human_count_of(written.mesh.triangles.size(), "triangle") << ", "
            << human_count(written.mesh.positions.size()) << " vertices, from "
            << human_count(result.surface.tetrahedra) << " tetrahedra\n  ";
  if (written.components != written.total_components) {
    std::cout << "whole surface: "
              << human_count_of(static_cast<std::uint64_t>(topology.triangles), "triangle") << ", ";
  }
  std::cout << "Euler characteristic " << topology.euler_characteristic << ", "
            << human_count_of(static_cast<std::uint64_t>(topology.components), "component") << ", "
            << topology.border_edges << " edges on the border, " << topology.open_edges << " open, "
            << topology.nonmanifold_edges << " non-manifold\n";
  if (result.self_intersecting) {
    std::cout << "  " << human_count_of(*result.self_intersecting, "triangle")
              << " that intersect others\n";
  }
  if (result.model) {
    std::cout << result.model->file << ": " << human_count(result.model->tetrahedra)
              << " tetrahedra, " << human_count(result.model->points) << " points\n";
  }
}

}  // namespace multitetra
