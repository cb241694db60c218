// Surfaces and models by the method itself: exact errors, uniform levels, models as files.
#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "common/base/exit_codes.hpp"
#include "server/core/planning/budget.hpp"
#include "server/dataset/dataset.hpp"
#include "server/extraction/model_file.hpp"
#include "server/extraction/normal_encoder.hpp"
#include "server/extraction/reference_extractor.hpp"
#include "server/programs/commands.hpp"
#include "server/programs/local_output.hpp"
#include "server/programs/thread_options.hpp"

namespace multitetra {
namespace {

struct ReferenceArguments {
  LocalArguments local = {};
  std::string errors = "exact";
  std::optional<int> level = {};
  std::string model_file = {};
  std::string model_scope = "all";
};

std::shared_ptr<const Model> model_of(const ReferenceArguments& arguments,
                                      const ReferenceExtractor& extractor, const ResolvedStep& step,
                                      const DatasetInfo& info) {
  if (arguments.level) {
    return std::make_shared<UniformModel>(extractor.field().grid(), *arguments.level);
  }
  const bool has_spectrum = info.grid_exponent > kSpectrumExponent;
  return arguments.errors == "spectrum" && has_spectrum ? extractor.spectrum_model(step)
                                                        : extractor.exact_model(step);
}

LocalSurface surface_of(const ReferenceArguments& arguments, const ReferenceExtractor& extractor,
                        const ResolvedStep& step, const Model& model,
                        const PreparedVolume& dataset) {
  const IsosurfaceRequest& request = step.request();
  const TiledMesh tiles = extractor.extract(step, model);
  LocalSurface surface{.request = request,
                       .mesh = weld(tiles.tiles, request.lattice_resolution),
                       .whole = {.tetrahedra = tiles.tetrahedra,
                                 .active_tetrahedra = tiles.active_tetrahedra,
                                 .tiles = tiles.tiles.size()},
                       .is_error_bounded = !arguments.level};
  for (const TileMesh& tile : tiles.tiles) {
    surface.whole.simplification_bound =
        std::max(surface.whole.simplification_bound, tile.simplification_bound);
  }
  if (arguments.level) {  // It is coarse everywhere, including where the data ends.
    surface.finest_spacing =
        std::max(1, (1 << dataset.info.grid_exponent) >> (*arguments.level / 3));
  }
  surface.whole.digest = digest(surface.mesh);
  surface.mesh.normals =
      rounded_normals(dataset, surface.mesh, request.normal_bits, NormalSource::kSamples);
  return surface;
}

// Writes the model file, without cells beyond the data. Returns its report.
Json write_model(const ReferenceArguments& arguments, const Model& model, const Field& field,
                 double isovalue, const Affine& to_output) {
  const ModelScope scope =
      arguments.model_scope == "surface" ? ModelScope::kSurface : ModelScope::kAll;
  const ModelCells cells = model_cells(model, field, isovalue, scope);
  write_file(arguments.model_file, vtu_file(cells, to_output));
  return {{"file", arguments.model_file},
          {"scope", arguments.model_scope},
          {"tetrahedra", cells.cells.size()},
          {"points", cells.points.size()}};
}

int reference(const ReferenceArguments& arguments) {
  const LocalArguments& local = arguments.local;
  const ThreadLimit limit(local.threads);
  static_cast<void>(mesh_format_of(local.output.file, local.surface));
  if (has_budget(local.surface.query.request) || local.surface.query.isovalues.size() > 1) {
    throw ExitError(kUsage,
                    "--max-triangles, --max-bytes and several isovalues are for `extract`.");
  }
  require_outputs_of({local.output.file}, local.output,
                     {{"file", local.dataset},
                      {"--threshold-grid", local.surface.threshold_grid},
                      {"--color-by", local.surface.query.color_by}},
                     arguments.model_file);
  Progress progress("reference", arguments.model_file.empty() ? 4 : 5,
                    local.output.quiet || local.output.json);
  progress.begin("open");
  const DatasetPtr dataset = open_dataset(local.dataset);
  LocalOutput output(local, progress);
  IsosurfaceRequest request = output.requests(dataset->info).front();
  // Simplification has no error bound to obey on a uniform level.
  if (arguments.level) request.simplify = false;
  progress.begin("surface");
  const ReferenceExtractor extractor(*dataset);
  const ResolvedStep step = resolved_step({.request = request}, dataset->info);
  const std::shared_ptr<const Model> model = model_of(arguments, extractor, step, dataset->info);
  LocalSurface surface = surface_of(arguments, extractor, step, *model, *dataset);
  progress.begin("checks");
  output.add(std::move(surface), dataset->info, local.output.file);
  output.describe({{"errors", arguments.errors}});
  if (arguments.level) output.describe({{"level", *arguments.level}});
  output.write();
  if (!arguments.model_file.empty()) {
    progress.begin("model_file");
    output.describe({{"model", write_model(arguments, *model, extractor.field(), request.isovalue,
                                           output_map(local.surface, dataset->info))}});
  }
  return output.report();
}

}  // namespace

void add_reference_command(Command& program, Run& run) {
  const auto a = std::make_shared<ReferenceArguments>();
  Command* command = program.add_subcommand(
      "reference", "Write a surface, and its tetrahedra, from exact errors or a uniform level");
  add_local_options(*command, a->local,
                    "Dataset: a file (.mtd) or an address; its volume must fit into memory");
  command
      ->add_option("--errors", a->errors,
                   "exact: a pass over the whole volume; spectrum: those stored in the dataset")
      ->one_of({"exact", "spectrum"})
      ->capture_default_str();
  command
      ->add_option("--level", a->level,
                   "Instead of an error: all tetrahedra of this depth; 0 (twelve) to 3 N - 1 (full "
                   "resolution)")
      ->within(0, 3 * kMaxLatticeBits)
      ->excludes("--error");
  Option* const model_option =
      command
          ->add_option(
              "--model", a->model_file,
              "Also write the model's tetrahedra (.vtu); for ParaView, with their vertex values")
          ->type_name("FILE");
  command
      ->add_option(
          "--model-scope", a->model_scope,
          "Tetrahedra of --model; all: those that fill the volume, up to its last samples; "
          "surface: only those that the surface crosses")
      ->one_of({"all", "surface"})
      ->needs(model_option)
      ->capture_default_str();
  command->footer(
      "Surfaces are those of the paper's method without the error spectrum; `extract` makes them "
      "faster.\n"
      "Examples:\n"
      "  multitetra-server reference head.mtd --error 4 -o head.ply\n"
      "  multitetra-server reference head.mtd --error 4 --errors spectrum -o head.ply --model "
      "head.vtu\n"
      "  multitetra-server reference head.mtd --level 12 -o level.ply\n"
      "Exit codes: 0 done, 1 failed, 2 wrong usage, 6 the surface is empty.");
  command->callback([a, &run] { run = [a] { return reference(*a); }; });
}

}  // namespace multitetra
