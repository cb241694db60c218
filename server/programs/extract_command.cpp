#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "common/base/exit_codes.hpp"
#include "common/base/json.hpp"
#include "common/base/number_text.hpp"
#include "common/cli/output_files.hpp"
#include "common/cli/surface_files.hpp"
#include "common/cli/surface_options.hpp"
#include "common/cli/terminal.hpp"
#include "common/json/json_report.hpp"
#include "common/mesh/content_digest.hpp"
#include "common/request/lattice_limit.hpp"
#include "common/request/request_notices.hpp"
#include "common/request/threshold_shrinking.hpp"
#include "common/wire/mesh_files.hpp"
#include "common/wire/tile.hpp"
#include "server/core/planning/budget.hpp"
#include "server/core/surface/vertex_normals.hpp"
#include "server/dataset/dataset.hpp"
#include "server/extraction/model_file.hpp"
#include "server/extraction/reference_extractor.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "server/programs/commands.hpp"
#include "server/programs/extract_report.hpp"
#include "server/programs/extract_series.hpp"
#include "server/programs/progress.hpp"
#include "server/programs/thread_options.hpp"
#include "server/programs/vertex_colors.hpp"
#include "server/service/caching_surface_provider.hpp"
#include "server/stream/stream_plan.hpp"
#include "server/volume/volume_files.hpp"

namespace multitetra {
namespace {

// Reads thresholds from a volume of any format.
Result<ThresholdGrid> read_volume_of_thresholds(const std::filesystem::path& file,
                                                double elsewhere) {
  try {
    const Volume volume = read_volume(file);
    std::vector<float> thresholds(volume.size());
    std::visit(
        [&](const auto& samples) { std::copy(samples.begin(), samples.end(), thresholds.begin()); },
        volume.samples);
    return shrunk(
        {.dims = volume.dims, .index_to_world = volume.index_to_world, .thresholds = thresholds},
        elsewhere);
  } catch (const VolumeFileError& error) {
    return fail(ErrorCode::kInvalidArgument, error.what());
  }
}

MeshFormat format_of(const std::string& output) {
  const auto format = mesh_format_from(std::filesystem::path(output).extension().string());
  if (!format) {
    throw std::invalid_argument(
        "\"" + output + "\" has no mesh file suffix; use .ply, .stl, .obj, .glb, .drc or .vtp.");
  }
  return *format;
}

// The model of the reference extractor, if it is needed.
struct ReferenceModel {
  std::unique_ptr<const ReferenceExtractor> extractor;
  std::shared_ptr<const Model> model;
  bool is_for_file_only = false;  // SurfaceExtractor makes the same surface faster.
};
ReferenceModel reference_model(const ExtractArguments& arguments, const PreparedVolume& dataset,
                               const IsosurfaceRequest& request) {
  const bool is_exact =
      arguments.errors == "exact" || dataset.info.grid_exponent <= kSpectrumExponent;
  if (!arguments.level && !is_exact && arguments.model_file.empty()) return {};
  ReferenceModel reference;
  reference.extractor = std::make_unique<const ReferenceExtractor>(dataset);
  if (arguments.level) {
    reference.model =
        std::make_shared<UniformModel>(reference.extractor->field().grid(), *arguments.level);
  } else if (is_exact) {
    reference.model =
        reference.extractor->exact_model(resolved_step({.request = request}, dataset.info));
  } else {
    reference.model =
        reference.extractor->spectrum_model(resolved_step({.request = request}, dataset.info));
    reference.is_for_file_only = true;
  }
  return reference;
}

// Omits cells beyond the data and, unless requested, cells without surface.
WrittenModel write_model(const ExtractArguments& arguments, const ReferenceModel& reference,
                         double isovalue, const Affine& to_output) {
  const ModelScope scope =
      arguments.model_scope == "surface" ? ModelScope::kSurface : ModelScope::kAll;
  const ModelCells cells =
      model_cells(*reference.model, reference.extractor->field(), isovalue, scope);
  write_file(arguments.model_file, vtu_file(cells, to_output));
  return {.file = arguments.model_file,
          .tetrahedra = cells.cells.size(),
          .points = cells.points.size()};
}

// Makes the final step that a server would send for a request with a budget.
StepResult affordable(const std::shared_ptr<const SurfaceExtractor>& extractor,
                      const IsosurfaceRequest& requested) {
  auto made = make_next_step(CachingSurfaceProvider(extractor),
                             {.request = requested, .steps = StepPolicy::kFinalOnly}, {},
                             {.as_meshes = true});
  if (!made) throw std::runtime_error(made.error().text);
  return *std::move(made);
}

// Returns the tiles of a step, decoding them if necessary.
TiledMesh surface_of(const StepResult& made) {
  const EncodedStep& step = made.encoded;
  TiledMesh surface{
      .tetrahedra = step.tetrahedra, .active_tetrahedra = step.active_tetrahedra, .tiles = {}};
  for (std::size_t i = 0; i < step.tiles.size(); ++i) {
    const TileSummary& summary = step.tiles[i].summary;
    LatticeMesh mesh = step.meshes.empty() ? decode_tile(*step.tiles[i].payload, summary,
                                                         made.step.request.lattice_resolution,
                                                         made.step.request.normal_bits)
                                                 .value()
                                           : *step.meshes[i];
    surface.tiles.push_back({.cube = summary.cube,
                             .mesh = std::move(mesh),
                             .simplification_bound = summary.simplification_bound});
  }
  return surface;
}

// For a folder of datasets. Models and levels are those of one dataset.
int extract_folder(const ExtractArguments& arguments, MeshFormat format) {
  if (arguments.level || !arguments.model_file.empty() || arguments.errors != "spectrum") {
    throw ExitError(kUsage, "--level, --model and --errors are for one dataset, not a folder.");
  }
  return extract_series({.folder = arguments.file,
                         .output = arguments.output,
                         .format = format,
                         .report = arguments.report,
                         .json = arguments.json,
                         .quiet = arguments.quiet},
                        arguments.surface);
}

// One of the surfaces, its model and its file.
struct Extraction {
  ExtractResult result;
  ReferenceModel reference = {};
  OutputSurface output = {};
  std::string file = {};
  WrittenMesh written = {};
};

// Returns a file for each isovalue; a GLB contains all surfaces.
std::vector<std::string> files_of(const ExtractArguments& arguments, MeshFormat format) {
  const std::vector<double>& isovalues = arguments.surface.query.isovalues;
  if (isovalues.size() <= 1) return {arguments.output};
  std::vector<std::string> files;
  for (const double isovalue : isovalues) {
    files.push_back(format == MeshFormat::kGlb
                        ? arguments.output
                        : file_of_part(arguments.output, shortest_text(isovalue)).string());
  }
  return files;
}

void require_outputs_of(const ExtractArguments& arguments, std::vector<std::string> files) {
  files.erase(std::unique(files.begin(), files.end()), files.end());
  std::vector<NamedFile> outputs;
  for (const std::string& file : files) outputs.push_back({"--output", file});
  outputs.push_back({"--report", arguments.report});
  outputs.push_back({"--model", arguments.model_file});
  require_outputs(outputs, {{"file", arguments.file},
                            {"--threshold-grid", arguments.surface.threshold_grid},
                            {"--color-by", arguments.surface.query.color_by}});
}

void require_one_isovalue(const ExtractArguments& arguments) {
  if (!arguments.model_file.empty() || has_budget(arguments.surface.query.request)) {
    throw ExitError(kUsage, "--model, --max-triangles and --max-bytes are for one isovalue.");
  }
}

// Extracts and checks one surface.
Extraction extracted(const ExtractArguments& arguments, const std::string& file,
                     const DatasetPtr& dataset,
                     const std::shared_ptr<const SurfaceExtractor>& extractor,
                     const IsosurfaceRequest& requested, const VertexColors& colors,
                     Notices& notices, Progress& progress) {
  const DatasetInfo& info = dataset->info;
  if (const auto fits = check_lattice(requested, info); !fits) {
    throw ExitError(kUsage, "--lattice: " + fits.error().text);
  }
  notices.add(request_notices(requested, info));
  progress.begin("surface");
  std::optional<StepResult> within_budget;
  if (has_budget(requested)) within_budget = affordable(extractor, requested);
  IsosurfaceRequest request = within_budget ? within_budget->step.request : requested;
  notices.add(request_notices(request, info));
  // Simplification has no error bound to obey on a uniform level.
  if (arguments.level) request.simplify = false;
  Extraction extraction{.result = {.request = request},
                        .reference = reference_model(arguments, *dataset, request),
                        .file = file};
  const ReferenceModel& reference = extraction.reference;
  ExtractResult& result = extraction.result;
  result.surface = reference.model && !reference.is_for_file_only
                       ? reference.extractor->extract(resolved_step({.request = request}, info),
                                                      *reference.model)
                   : within_budget ? surface_of(*within_budget)
                                   : extractor->extract(StepRequest{.request = request});
  progress.begin("checks");
  LatticeMesh mesh = weld(result.surface.tiles, request.lattice_resolution);
  if (request.normal_bits != 0) {  // Files store them in full precision.
    mesh.normals = vertex_normals(*dataset, mesh.vertices, mesh.resolution, NormalSource::kSamples);
  }
  // A uniform level is coarse everywhere, including where the data ends.
  const std::int32_t finest =
      arguments.level ? std::max(1, (1 << info.grid_exponent) >> (*arguments.level / 3)) : 1;
  MeasuredSurface& measured = result.measured;
  measured = {
      .topology = multitetra::topology(
          mesh, data_border(info, request.lattice_resolution, request.topology_tolerance, finest)),
      .simplification_bound = simplification_bound(result.surface)};
  for (TileMesh& tile : result.surface.tiles) tile.mesh = {};  // Only their number is reported.
  result.content = digest(mesh);
  if (arguments.json || !arguments.report.empty()) {
    measure(measured, mesh, arguments.surface, request, info, !arguments.level);
    notices.add(volume_notice(*measured.measures, measured.distance_bound));
  }
  if (measured.topology.triangles == 0) notices.add(empty_surface_text(request, info));
  colors.add_scalars(mesh, info, notices, arguments.quiet);
  extraction.output = output_surface(mesh, arguments.surface, info);
  colors.paint(extraction.output.mesh);
  const std::string left_out = removed_text(extraction.output);
  if (!left_out.empty()) notices.add("The file has " + left_out + ".");
  return extraction;
}

void write_meshes(std::vector<Extraction>& surfaces, const DatasetInfo& info, MeshCodec codec,
                  Notices& notices) {
  const auto name_of = [&](const Extraction& surface) {
    SurfaceName name = surface_name(info);
    if (surfaces.size() > 1) {
      name.text = "isovalue " + shortest_text(surface.result.request.isovalue);
      name.color.reset();
    }
    return name;
  };
  std::vector<NamedMesh> files;
  for (const Extraction& surface : surfaces) {
    files.push_back({.file = surface.file, .name = name_of(surface), .surface = &surface.output});
  }
  const MeshFormat format = format_of(surfaces.front().file);
  const bool is_simplified = std::any_of(surfaces.begin(), surfaces.end(), [](const auto& one) {
    return one.result.measured.simplification_bound > 0;
  });
  const std::vector<WrittenMesh> written = write_surfaces(files, format, codec, is_simplified);
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    Extraction& surface = surfaces[i];
    surface.written = written[i];
    if (const auto& crossing = written[i].self_intersections) {
      surface.result.measured.self_intersecting = crossing->triangles;
    }
    if (format == MeshFormat::kStl)
      notices.add(printing_notices(surface.file, surface.written, info));
  }
}

int extract(const ExtractArguments& arguments) {
  const ThreadLimit limit(arguments.threads);
  const MeshFormat format = format_of(arguments.output);
  require_codec(arguments.surface, format == MeshFormat::kGlb);
  if (is_folder_of_datasets(arguments.file)) return extract_folder(arguments, format);
  const std::vector<std::string> files = files_of(arguments, format);
  if (files.size() > 1) require_one_isovalue(arguments);
  require_outputs_of(arguments, files);
  const bool has_model_file = !arguments.model_file.empty();
  Progress progress("extract", 2 + 2 * files.size() + (has_model_file ? 1 : 0),
                    arguments.quiet || arguments.json);
  progress.begin("open");
  const DatasetPtr dataset = open_dataset(arguments.file);
  const DatasetInfo& info = dataset->info;
  const Result<std::vector<IsosurfaceRequest>> requested = requests_from(arguments.surface, info);
  if (!requested) throw std::invalid_argument(requested.error().text);
  Notices notices(arguments.quiet);
  const auto extractor = std::make_shared<const SurfaceExtractor>(dataset);
  const VertexColors colors(arguments.surface);
  std::vector<Extraction> surfaces;
  for (std::size_t i = 0; i < files.size(); ++i) {
    surfaces.push_back(extracted(arguments, files[i], dataset, extractor, (*requested)[i], colors,
                                 notices, progress));
  }
  const auto report_now = [&](bool is_written) {
    Json reports = Json::array();
    for (const Extraction& surface : surfaces) {
      reports.push_back(json_of(surface.result, arguments, notices.texts(), progress.seconds()));
      colors.describe(reports.back());
      if (is_written) add_file(reports.back(), surface.file, surface.output, surface.written);
    }
    const Json report = surfaces.size() == 1 ? reports.front() : Json{{"surfaces", reports}};
    write_report(report, arguments);
  };
  for (const Extraction& surface : surfaces) {
    if (surface.output.components > 0 || arguments.surface.allow_empty) continue;
    progress.finish();
    report_now(false);
    throw ExitError(kEmptySurface, not_written_text(surface.file));
  }
  progress.begin("file");
  write_meshes(surfaces, info, arguments.surface.query.codec, notices);
  notices.add(larger_file_notice(arguments.output, arguments.surface.query.request.max_bytes));
  if (has_model_file) {
    progress.begin("model_file");
    Extraction& only = surfaces.front();
    only.result.model = write_model(arguments, only.reference, only.result.request.isovalue,
                                    output_map(arguments.surface, info));
  }
  progress.finish();
  report_now(true);
  bool is_sound = true;
  for (const Extraction& surface : surfaces) {
    if (!arguments.json && !arguments.quiet) {
      print_result(surface.result, surface.output, surface.file);
    }
    is_sound = is_sound && surface.result.measured.topology.is_sound();
  }
  if (is_sound) return 0;
  std::cerr << "multitetra-server: the mesh has open, non-manifold or degenerate parts; this is a "
               "bug, please report it.\n";
  return 1;
}

}  // namespace

void add_extract_command(Command& program, Run& run) {
  const auto a = std::make_shared<ExtractArguments>();
  a->surface.threshold_files = {.formats = "Any format that `prepare` reads (`formats` lists them)",
                                .read = read_volume_of_thresholds};
  Command* command =
      program.add_subcommand("extract", "Write isosurfaces as mesh files, without a network");
  command
      ->add_option(
          "file", a->file,
          "Dataset: a file (.mtd) or the address of a dataset (https://, s3://bucket/key); or a "
          "folder of labels, whose meshes then fit together")
      ->required()
      ->type_name("DATASET");
  command
      ->add_option("-o,--output", a->output,
                   "Mesh file: .ply, .stl, .obj, .glb, .drc or .vtp. Several surfaces are parts of "
                   "one .glb, or one file each, with the dataset or isovalue in its name")
      ->required()
      ->type_name("FILE");
  add_request_options(
      *command, a->surface,
      {FieldGroup::kSurface, FieldGroup::kThresholds, FieldGroup::kSize, FieldGroup::kColors});
  add_output_options(*command, a->surface);
  add_threads_option(*command, a->threads);
  command->add_option("--report", a->report, "Write the JSON report to this file")
      ->type_name("FILE");
  command->add_flag("--json", a->json, "Print a JSON report");
  command->add_flag("--quiet", a->quiet, "Print errors only");
  command->begin_group("Models");
  command
      ->add_option("--errors", a->errors,
                   "spectrum: those stored in the dataset; exact: the reference, a pass over the "
                   "whole volume")
      ->one_of({"exact", "spectrum"})
      ->capture_default_str();
  command
      ->add_option("--level", a->level,
                   "Instead of an error: all tetrahedra of this depth, 0 (twelve) to 3 N - 1 (full "
                   "resolution)")
      ->within(0, 3 * kMaxLatticeBits)
      ->excludes("--error");
  Option* const model_option =
      command
          ->add_option(
              "--model", a->model_file,
              "Also write the model's tetrahedra with their vertex values, for ParaView (.vtu)")
          ->type_name("FILE");
  command
      ->add_option("--model-scope", a->model_scope,
                   "all: tetrahedra that fill the volume, up to its last samples; surface: only "
                   "those that the surface crosses")
      ->one_of({"all", "surface"})
      ->needs(model_option)
      ->capture_default_str();
  command->footer(
      "Examples:\n"
      "  multitetra-server extract head.mtd -o head.ply\n"
      "  multitetra-server extract head.mtd --isovalue 1200.5 --error 0.5 -o bone.glb\n"
      "  multitetra-server extract head.mtd --isovalue 500.5,1200.5 -o skin_and_bone.glb\n"
      "  multitetra-server extract density.mtd --color-by temperature.mtd -o density.ply\n"
      "  multitetra-server extract head.mtd --error 2 --unit world -o head.stl --json\n"
      "  multitetra-server extract head.mtd --error 4 -o head.ply --model head.vtu\n"
      "  multitetra-server extract organs/ --error 0.5 -o organs.glb\n"
      "Exit codes: 0 done, 1 failed, 2 wrong usage, 6 the surface is empty.");
  command->callback([a, &run] { run = [a] { return extract(*a); }; });
}

}  // namespace multitetra
