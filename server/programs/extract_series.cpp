#include "server/programs/extract_series.hpp"

#include <algorithm>
#include <iostream>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#include "common/base/exit_codes.hpp"
#include "common/base/json.hpp"
#include "common/cli/human_units.hpp"
#include "common/cli/output_files.hpp"
#include "common/cli/surface_files.hpp"
#include "common/cli/terminal.hpp"
#include "common/json/json_report.hpp"
#include "common/mesh/mesh_checks.hpp"
#include "common/request/isosurface_request.hpp"
#include "common/request/request_notices.hpp"
#include "server/extraction/touching_extraction.hpp"
#include "server/programs/measured_surface.hpp"
#include "server/programs/progress.hpp"
#include "server/programs/vertex_colors.hpp"

namespace multitetra {
namespace {

std::vector<DatasetPtr> opened(const std::string& folder) {
  std::vector<DatasetPtr> datasets;
  for (const std::string& place : datasets_in(folder)) datasets.push_back(open_dataset(place));
  if (datasets.empty()) throw ExitError(kUsage, "There is no dataset in " + folder + ".");
  const DatasetInfo& first = datasets.front()->info;
  for (const DatasetPtr& dataset : datasets) {
    const DatasetInfo& info = dataset->info;
    if (info.dims == first.dims && info.margin == first.margin &&
        info.index_to_world == first.index_to_world) {
      continue;
    }
    throw ExitError(kUsage, "\"" + info.name + "\" and \"" + first.name +
                                "\" have different grids. Extract such datasets one by one.");
  }
  return datasets;
}

struct ExtractedSurface {
  const DatasetInfo* info = nullptr;
  MeasuredSurface measured;
  std::size_t common_triangles = 0;
  OutputSurface output;
  std::string file;
  WrittenMesh written = {};
};

Json json_of(const ExtractedSurface& surface) {
  Json report = {{"dataset", surface.info->name}, {"name", surface_name(*surface.info).text}};
  if (const auto label = surface_name(*surface.info).label) report["label"] = *label;
  report.update(json_of(surface.measured));
  report["common_triangles"] = surface.common_triangles;
  add_file(report, surface.file, surface.output, surface.written);
  if (surface.file.empty()) report["mesh_file"] = nullptr;
  return report;
}

bool has_report(const ExtractSeriesArguments& arguments) {
  return arguments.json || !arguments.report.empty();
}

// Writes the files. Unless `allow_empty` is set, clears the names of those without any triangle,
// with a notice, and does not write them.
void write_meshes(const ExtractSeriesArguments& arguments, std::vector<ExtractedSurface>& surfaces,
                  const SurfaceArguments& surface, Notices& notices) {
  std::vector<NamedMesh> files;
  for (const ExtractedSurface& one : surfaces) {
    files.push_back({.file = one.file, .name = surface_name(*one.info), .surface = &one.output});
  }
  if (!surface.allow_empty) notices.add(leave_out_empty_files(files));
  const bool is_for_printing = arguments.format == MeshFormat::kStl;
  const bool counts_intersections =
      surface.query.request.simplify && (has_report(arguments) || is_for_printing);
  const std::vector<WrittenMesh> written =
      write_surfaces(files, arguments.format, surface.query.codec, counts_intersections);
  for (std::size_t i = 0; i < files.size(); ++i) {
    surfaces[i].file = files[i].file;
    surfaces[i].written = written[i];
    if (const auto& crossing = written[i].self_intersections) {
      surfaces[i].measured.self_intersecting = crossing->triangles;
    }
    if (is_for_printing)
      notices.add(printing_notices(surfaces[i].file, written[i], *surfaces[i].info));
  }
}

void print_facts(const ExtractedSurface& surface) {
  const auto count = [](std::int64_t number) { return static_cast<std::uint64_t>(number); };
  const MeshTopology& topology = surface.measured.topology;
  const std::string file = surface.file.empty() ? "not written" : surface.file;
  std::cout << file << ": \"" << surface_name(*surface.info).text << "\", "
            << human_count_of(count(topology.triangles), "triangle") << ", "
            << human_count(surface.common_triangles) << " of them shared with neighbors, "
            << human_count_of(count(topology.components), "component") << ", "
            << topology.open_edges << " open edges, " << topology.nonmanifold_edges
            << " non-manifold\n";
}

// Surfaces of a folder are simplified from full resolution, with exact topology.
void require_folder_request(const IsosurfaceRequest& request) {
  if (has_budget(request) || request.normal_bits != 0 || request.topology_tolerance != 0 ||
      request.topology_rule != TopologyRule::kExact ||
      request.error_measure != ErrorMeasure::kCertified) {
    throw ExitError(kUsage,
                    "--max-triangles, --max-bytes, --normals, --topology-tolerance, "
                    "--topology-rule and --bound are for one dataset, not a folder.");
  }
}

// Surfaces of one time may touch each other.
TouchingSurfaces extract_by_time(const std::vector<DatasetPtr>& datasets,
                                 const IsosurfaceRequest& request) {
  std::map<std::optional<double>, std::vector<std::size_t>> by_time;
  for (std::size_t i = 0; i < datasets.size(); ++i) {
    const auto& member = datasets[i]->info.member;
    by_time[member ? member->time : std::nullopt].push_back(i);
  }
  TouchingSurfaces all{.surfaces = std::vector<Simplified>(datasets.size()),
                       .common_triangles = std::vector<std::size_t>(datasets.size())};
  for (const auto& [time, members] : by_time) {
    std::vector<DatasetPtr> of_time;
    for (const std::size_t i : members) of_time.push_back(datasets[i]);
    TouchingSurfaces extracted = extract_touching(of_time, request);
    for (std::size_t i = 0; i < members.size(); ++i) {
      all.surfaces[members[i]] = std::move(extracted.surfaces[i]);
      all.common_triangles[members[i]] = extracted.common_triangles[i];
    }
  }
  return all;
}

// Checks and measures a mesh, and makes its output. Adds notices that name the surface.
void check(ExtractedSurface& one, Simplified simplified, const ExtractSeriesArguments& arguments,
           const SurfaceArguments& surface, const IsosurfaceRequest& request,
           const VertexColors& colors, Notices& notices) {
  const auto add_notice = [&](const std::string& text) {
    notices.add("\"" + surface_name(*one.info).text + "\"" + text);
  };
  MeasuredSurface& measured = one.measured;
  measured.topology = topology(simplified.mesh, data_border(*one.info, request.lattice_resolution,
                                                            request.topology_tolerance));
  measured.simplification_bound = simplified.bound;
  if (has_report(arguments)) {
    measure(measured, simplified.mesh, surface, request, *one.info);
    for (const std::string& text : volume_notice(*measured.measures, measured.distance_bound)) {
      add_notice(": " + text);
    }
  }
  colors.add_scalars(simplified.mesh, *one.info, notices, arguments.quiet);
  one.output = output_surface(simplified.mesh, surface, *one.info);
  colors.paint(one.output.mesh);
  if (measured.topology.triangles == 0) {
    add_notice(": " + empty_surface_text(request, *one.info));
  }
  const std::string removed = removed_text(one.output);
  if (!removed.empty()) add_notice(" has " + removed + ".");
}

void write_report(const ExtractSeriesArguments& arguments, const IsosurfaceRequest& request,
                  const VertexColors& colors, const Progress& progress, const Notices& notices,
                  const std::vector<ExtractedSurface>& surfaces) {
  Json report = {{"parameters", multitetra::json_of(request)},
                 {"seconds", progress.seconds()},
                 {"notices", notices.texts()},
                 {"surfaces", Json::array()}};
  for (const ExtractedSurface& one : surfaces) {
    report["surfaces"].push_back(json_of(one));
    colors.describe(report["surfaces"].back());
  }
  if (!arguments.report.empty()) write_file(arguments.report, text_of(report));
  if (arguments.json) std::cout << text_of(report);
}

}  // namespace

int extract_series(const ExtractSeriesArguments& arguments, const SurfaceArguments& surface) {
  Progress progress("extract", 4, arguments.quiet || arguments.json);
  progress.begin("open");
  const std::vector<DatasetPtr> datasets = opened(arguments.folder);
  const DatasetInfo& first = datasets.front()->info;
  const Result<IsosurfaceRequest> request = request_of(surface, first);
  if (!request) throw std::invalid_argument(request.error().text);
  require_folder_request(*request);
  const VertexColors colors(surface);
  std::vector<const DatasetInfo*> infos;
  for (const DatasetPtr& dataset : datasets) infos.push_back(&dataset->info);
  std::vector<ExtractedSurface> surfaces(datasets.size());
  const std::vector<std::string> files = files_of(arguments.output, arguments.format, infos);
  std::vector<NamedFile> outputs = {{"--report", arguments.report}};
  for (std::size_t i = 0; i < datasets.size(); ++i) {
    surfaces[i].info = infos[i];
    surfaces[i].file = files[i];
  }
  for (const std::string& file : std::set(files.begin(), files.end())) {
    outputs.push_back({"--output", file});
  }
  require_outputs(outputs, {{"--threshold-grid", surface.threshold_grid},
                            {"--color-by", surface.query.color_by}});
  Notices notices(arguments.quiet);
  notices.add(request_notices(*request, first));

  progress.begin("surfaces");
  TouchingSurfaces extracted = extract_by_time(datasets, *request);
  progress.begin("checks");
  for (std::size_t i = 0; i < datasets.size(); ++i) {
    surfaces[i].common_triangles = extracted.common_triangles[i];
    check(surfaces[i], std::move(extracted.surfaces[i]), arguments, surface, *request, colors,
          notices);
  }
  const bool is_empty = std::all_of(surfaces.begin(), surfaces.end(),
                                    [](const auto& one) { return one.output.components == 0; });
  if (is_empty && !surface.allow_empty) {
    progress.finish();
    for (ExtractedSurface& one : surfaces) one.file.clear();  // Not written.
    write_report(arguments, *request, colors, progress, notices, surfaces);
    throw ExitError(kEmptySurface, not_written_text(arguments.output));
  }
  progress.begin("files");
  write_meshes(arguments, surfaces, surface, notices);
  progress.finish();

  write_report(arguments, *request, colors, progress, notices, surfaces);
  if (!arguments.json && !arguments.quiet) {
    for (const ExtractedSurface& one : surfaces) print_facts(one);
  }
  const bool is_sound = std::all_of(surfaces.begin(), surfaces.end(), [](const auto& one) {
    return one.measured.topology.is_sound();
  });
  if (is_sound) return kOk;
  std::cerr << "multitetra-server: a mesh has open, non-manifold or degenerate parts; this is a "
               "bug, please report it.\n";
  return kFailed;
}

}  // namespace multitetra
