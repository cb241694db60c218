#include "common/cli/surface_output.hpp"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <map>
#include <optional>
#include <set>

#include "common/base/exit_codes.hpp"
#include "common/base/json.hpp"
#include "common/cli/human_units.hpp"
#include "common/cli/output_files.hpp"
#include "common/request/painted_mesh.hpp"
#include "common/request/request_notices.hpp"
#include "common/wire/scene_file.hpp"

namespace multitetra {

void add_output_options(Command& command, SurfaceArguments& surface, OutputArguments& output) {
  command
      .add_option(
          "-o,--output", output.file,
          "Mesh file: .ply, .stl, .obj, .glb, .3mf, .drc or .vtp. Several surfaces of one time "
          "are parts of one .glb; otherwise one file each, with the dataset or isovalue in "
          "its name")
      ->required()
      ->type_name("FILE");
  add_output_options(command, surface);
  command
      .add_option("--report", output.report,
                  "Write a JSON report to this file, also of an empty surface or a failed fetch")
      ->type_name("FILE")
      ->group("Reports");
  command.add_flag("--json", output.json, "Print the JSON report")->group("Reports");
  command.add_flag("--quiet", output.quiet, "Print errors only");
}

MeshFormat mesh_format_of(const std::string& file, const SurfaceArguments& arguments) {
  const auto format = mesh_format_from(std::filesystem::path(file).extension().string());
  if (!format) {
    throw ExitError(
        kUsage, "\"" + file +
                    "\" has no mesh file suffix; use .ply, .stl, .obj, .glb, .3mf, .drc or .vtp.");
  }
  require_codec(arguments, *format == MeshFormat::kGlb);
  return *format;
}

std::vector<std::string> files_of(const std::string& output, MeshFormat format,
                                  std::span<const DatasetInfo* const> datasets) {
  const auto series = [](const DatasetInfo* one) {
    return one->member ? one->member->series : std::string();
  };
  const auto time = [](const DatasetInfo* one) {
    return one->member ? one->member->time : std::nullopt;
  };
  const auto have_same = [&](const auto& property) {
    return std::all_of(datasets.begin(), datasets.end(), [&](const DatasetInfo* one) {
      return property(one) == property(datasets.front());
    });
  };
  const bool is_one_scene = holds_several(format) && have_same(time);
  const bool is_one_series = have_same(series);
  std::vector<std::string> files;
  for (const DatasetInfo* const one : datasets) {
    const std::string prefix = series(one) + ".";
    const bool has_prefix = is_one_series && one->name.starts_with(prefix);
    const std::string name = has_prefix ? one->name.substr(prefix.size()) : one->name;
    files.push_back(is_one_scene ? output : file_of_part(output, name).string());
  }
  return files;
}

void require_outputs_of(std::vector<std::string> files, const OutputArguments& output,
                        const std::vector<NamedFile>& inputs, const std::string& model_file) {
  files.erase(std::unique(files.begin(), files.end()), files.end());
  std::vector<NamedFile> outputs;
  for (const std::string& file : files) outputs.push_back({"--output", file});
  outputs.push_back({"--report", output.report});
  outputs.push_back({"--model", model_file});
  require_outputs(outputs, inputs);
}

void OutputPart::add_notices(const std::vector<std::string>& texts) {
  for (const std::string& text : texts) {
    notices->add(names_itself ? "\"" + name.text + "\": " + text : text);
  }
}

namespace {

// Measures the components in the file.
void measure(SurfaceReport& report, const LatticeMesh& mesh, const DatasetInfo& info,
             double min_component) {
  report.open_reason = open_reason(info);
  report.measures = measures_from(mesh, min_component, grid_to_world(info));
  if (!report.surface->error_bound) return;
  report.distance_bound =
      *report.surface->error_bound + lattice_rounding_world(info, mesh.resolution);
}

}  // namespace

void finish(OutputPart& part, const LatticeMesh& mesh, const SurfaceArguments& arguments,
            const OutputArguments& output) {
  SurfaceReport& report = part.report;
  const DatasetInfo& info = *part.info;
  report.dataset = info.name;
  report.name = part.name;
  report.coordinates = name(arguments.query.coordinates);
  report.shift = arguments.shift;
  if (report.surface->topology.triangles == 0) {
    part.add_notices({empty_surface_text(report.request, info)});
  }
  part.notices->add(request_notices(report.request, info));
  part.surface = output_surface(mesh, arguments, info);
  if (output.has_report()) {
    measure(report, mesh, info, arguments.query.min_component);
    if (report.distance_bound && arguments.query.codec == MeshCodec::kMeshopt) {
      *report.distance_bound += position_rounding(part.surface.mesh);
    }
    part.add_notices(volume_notice(*report.measures, report.distance_bound));
  }
  part.add_notices(missing_values_notice(mesh.scalars, report.color_by));
  paint(part.surface.mesh, report.colors, arguments.query.colors);
  if (const auto format = mesh_format_from(std::filesystem::path(part.file).extension().string())) {
    part.add_notices(left_out_notices(part.surface.mesh, *format));
  }
  const std::string removed = removed_text(part.surface);
  if (!removed.empty())
    part.add_notices({std::string("The ") + part.product + " has " + removed + "."});
}

const OutputPart* forbidden_empty(std::span<const OutputPart> parts,
                                  const SurfaceArguments& arguments, bool may_lack_some) {
  if (arguments.allow_empty) return nullptr;
  const auto is_empty = [](const OutputPart& part) { return part.surface.components == 0; };
  const auto first = std::find_if(parts.begin(), parts.end(), is_empty);
  const bool is_allowed = may_lack_some && !std::all_of(parts.begin(), parts.end(), is_empty);
  return first == parts.end() || is_allowed ? nullptr : &*first;
}

namespace {

// Clears the names of files without any triangle.
void leave_out_empty_files(std::span<OutputPart> parts) {
  std::set<std::string> with_triangles;
  for (const OutputPart& part : parts) {
    if (part.surface.components > 0) with_triangles.insert(part.file);
  }
  OutputPart* first = nullptr;
  std::vector<std::string> names;
  for (OutputPart& part : parts) {
    if (with_triangles.contains(part.file)) continue;
    part.file.clear();
    names.push_back(part.name.text);
    if (first == nullptr) first = &part;
  }
  if (first != nullptr) first->notices->add(not_written_text(names));
}

// Writes one file, and returns what it holds of each surface.
std::vector<WrittenMesh> write_surfaces(const std::string& file,
                                        std::span<const NamedSurface> surfaces, MeshCodec codec,
                                        ReadBack counted) {
  const MeshFormat format =
      mesh_format_from(std::filesystem::path(file).extension().string()).value();
  try {
    SurfaceFile made = surface_file(surfaces, format, codec, counted);
    write_file(file, made.bytes);
    return std::move(made.written);
  } catch (const MeshCoordinatesError& error) {
    throw ExitError(kUsage, file + ": " + error.what() + " Here: --coordinates index, or --shift " +
                                error.shift + ", which moves the surface and is in the report.");
  }
}

// Returns the notices that 3D printers reject a file: it is open where the data ends, or triangles
// intersect others.
std::vector<std::string> printing_notices(const std::string& file, const WrittenMesh& written,
                                          const DatasetInfo& info) {
  std::vector<std::string> notices;
  const std::int64_t open = written.topology.border_edges;
  if (open > 0) {
    notices.push_back(file + " is open at " +
                      human_count_of(static_cast<std::uint64_t>(open), "edge") +
                      " and cannot be printed: it ends " + open_reason(info) +
                      ", or --min-component removes small open components.");
  }
  if (written.self_intersections && written.self_intersections->triangles > 0) {
    notices.push_back(file + " has " +
                      human_count_of(written.self_intersections->triangles, "triangle") +
                      " that intersect others; --intersection-free avoids them.");
  }
  return notices;
}

void complete(OutputPart& part, const WrittenMesh& written, bool is_for_printing) {
  part.report.mesh_file = part.file;
  part.report.components_written = part.surface.components;
  part.report.triangles_written = part.surface.mesh.triangles.size();
  part.report.written = written;
  if (is_for_printing) part.notices->add(printing_notices(part.file, written, *part.info));
  part.notices->add(larger_file_notice(part.file, part.max_bytes));
}

}  // namespace

void write_surface(const std::string& file, const NamedSurface& surface, MeshCodec codec) {
  static_cast<void>(write_surfaces(file, {&surface, 1}, codec, ReadBack::kElements));
}

void write_files(std::span<OutputPart> parts, const SurfaceArguments& arguments,
                 const OutputArguments& output, bool counts_self_intersections) {
  if (!arguments.allow_empty) leave_out_empty_files(parts);
  const MeshFormat format = mesh_format_of(output.file, arguments);
  // Only simplification makes triangles that intersect others.
  const bool is_simplified = std::any_of(parts.begin(), parts.end(), [](const OutputPart& part) {
    return part.report.surface->simplification_bound > 0;
  });
  const bool is_told =
      counts_self_intersections || output.has_report() || format == MeshFormat::kStl;
  const ReadBack counted =
      is_simplified && is_told ? ReadBack::kSelfIntersections : ReadBack::kTopology;
  std::map<std::string, std::vector<OutputPart*>> files;
  for (OutputPart& part : parts) {
    if (!part.file.empty()) files[part.file].push_back(&part);
  }
  for (const auto& [file, members] : files) {
    std::vector<NamedSurface> surfaces;
    for (const OutputPart* const part : members) surfaces.push_back({part->name, &part->surface});
    const std::vector<WrittenMesh> written =
        write_surfaces(file, surfaces, arguments.query.codec, counted);
    for (std::size_t i = 0; i < members.size(); ++i) {
      complete(*members[i], written[i], format == MeshFormat::kStl);
    }
  }
}

void write_report(std::vector<Json> reports, bool are_several, const OutputArguments& output) {
  if (!output.has_report()) return;
  const Json document = are_several ? Json{{"surfaces", std::move(reports)}} : reports.front();
  const std::string text = text_of(document);
  if (!output.report.empty()) write_file(output.report, text);
  if (output.json) std::cout << text;
}

}  // namespace multitetra
