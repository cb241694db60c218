#include "server/programs/extract_report.hpp"

#include <algorithm>
#include <cstdint>
#include <iostream>

#include "common/base/json.hpp"
#include "common/base/number_text.hpp"
#include "common/cli/human_units.hpp"
#include "common/cli/output_files.hpp"
#include "common/wire/mesh_files.hpp"

namespace multitetra {

double simplification_bound(const TiledMesh& surface) {
  double bound = 0;
  for (const TileMesh& tile : surface.tiles) bound = std::max(bound, tile.simplification_bound);
  return bound;
}

Json json_of(const ExtractResult& result, const ExtractArguments& arguments,
             const std::vector<std::string>& notices, const Json& seconds) {
  Json report = {{"tetrahedra", result.surface.tetrahedra},
                 {"active_tetrahedra", result.surface.active_tetrahedra},
                 {"tiles", result.surface.tiles.size()}};
  report.update(json_of(result.measured));
  report["content_digest"] = result.content.hex();
  report["seconds"] = seconds;
  report["parameters"] = json_of(result.request);
  report["parameters"]["coordinates"] = name(arguments.surface.query.coordinates);
  report["parameters"]["errors"] = arguments.errors;
  if (!arguments.surface.shift.empty()) report["parameters"]["shift"] = arguments.surface.shift;
  if (arguments.level) report["parameters"]["level"] = *arguments.level;
  report["notices"] = notices;
  report["mesh_file"] = nullptr;
  if (result.model) {
    report["model"] = {{"file", result.model->file},
                       {"scope", arguments.model_scope},
                       {"tetrahedra", result.model->tetrahedra},
                       {"points", result.model->points}};
  }
  return report;
}

void write_report(const Json& report, const ExtractArguments& arguments) {
  if (!arguments.report.empty()) write_file(arguments.report, text_of(report));
  if (arguments.json) std::cout << text_of(report);
}

void print_result(const ExtractResult& result, const OutputSurface& written,
                  const std::string& file) {
  const MeshTopology& topology = result.measured.topology;
  std::cout << file << ": isovalue " << shortest_text(result.request.isovalue) << ", "
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
  if (result.measured.self_intersecting) {
    std::cout << "  " << human_count_of(*result.measured.self_intersecting, "triangle")
              << " that intersect others\n";
  }
  if (result.model) {
    std::cout << result.model->file << ": " << human_count(result.model->tetrahedra)
              << " tetrahedra, " << human_count(result.model->points) << " points\n";
  }
}

}  // namespace multitetra
