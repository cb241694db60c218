#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "common/base/exit_codes.hpp"
#include "server/core/planning/budget.hpp"
#include "server/core/surface/vertex_normals.hpp"
#include "server/dataset/dataset.hpp"
#include "server/programs/commands.hpp"
#include "server/programs/extract_folder.hpp"
#include "server/programs/local_output.hpp"
#include "server/programs/thread_options.hpp"
#include "server/service/caching_surface_provider.hpp"
#include "server/service/surface_steps.hpp"

namespace multitetra {
namespace {

LocalSurface extracted(const std::shared_ptr<const SurfaceExtractor>& extractor,
                       const IsosurfaceRequest& request) {
  auto made = final_surface(std::make_shared<const CachingSurfaceProvider>(extractor), request);
  if (!made) throw std::runtime_error(made.error().text);
  Surface& own = made->surface;
  LocalSurface surface{.request = std::move(own.request),
                       .mesh = std::move(own.mesh),
                       .topology = made->topology,
                       .whole = {.tetrahedra = own.tetrahedra,
                                 .active_tetrahedra = own.active_tetrahedra,
                                 .tiles = own.tiles,
                                 .simplification_bound = own.simplification_bound,
                                 .digest = own.digest}};
  if (request.normal_bits != 0) {  // Files store them in full precision.
    surface.mesh.normals = vertex_normals(extractor->dataset(), surface.mesh.vertices,
                                          surface.mesh.resolution, NormalSource::kSamples);
  }
  return surface;
}

int extract(const LocalArguments& arguments) {
  const ThreadLimit limit(arguments.threads);
  const std::vector<std::string> files = files_of_isovalues(arguments);
  if (is_folder_of_datasets(arguments.dataset)) return extract_folder(arguments);
  if (files.size() > 1 && has_budget(arguments.surface.query.request)) {
    throw ExitError(kUsage, "--max-triangles and --max-bytes are for one isovalue.");
  }
  require_outputs_of(files, arguments.output,
                     {{"file", arguments.dataset},
                      {"--threshold-grid", arguments.surface.threshold_grid},
                      {"--color-by", arguments.surface.query.color_by}});
  Progress progress("extract", 2 + 2 * files.size(),
                    arguments.output.quiet || arguments.output.json);
  progress.begin("open");
  const DatasetPtr dataset = open_dataset(arguments.dataset);
  const DatasetInfo& info = dataset->info;
  const auto extractor = std::make_shared<const SurfaceExtractor>(dataset);
  LocalOutput output(arguments, progress);
  const std::vector<IsosurfaceRequest> requests = output.requests(info);
  for (std::size_t i = 0; i < files.size(); ++i) {
    progress.begin("surface");
    LocalSurface surface = extracted(extractor, requests[i]);
    progress.begin("checks");
    output.add(std::move(surface), info, files[i]);
  }
  output.write();
  return output.report();
}

}  // namespace

void add_extract_command(Command& program, Run& run) {
  const auto a = std::make_shared<LocalArguments>();
  Command* command =
      program.add_subcommand("extract", "Write isosurfaces as mesh files, without a network");
  add_local_options(
      *command, *a,
      "Dataset: a file (.mtd) or the address of a dataset (https://, s3://bucket/key); or a folder "
      "of labels, whose meshes then fit together");
  command->footer(
      "Examples:\n"
      "  multitetra-server extract head.mtd -o head.ply\n"
      "  multitetra-server extract head.mtd --isovalue 1200.5 --error 0.5 -o bone.glb\n"
      "  multitetra-server extract head.mtd --isovalue 500.5,1200.5 -o skin_and_bone.glb\n"
      "  multitetra-server extract density.mtd --color-by temperature.mtd -o density.ply\n"
      "  multitetra-server extract head.mtd --error 2 --unit world -o head.stl --json\n"
      "  multitetra-server extract organs/ --error 0.5 -o organs.glb\n"
      "Exit codes: 0 done, 1 failed, 2 wrong usage, 6 the surface is empty.");
  command->callback([a, &run] { run = [a] { return extract(*a); }; });
}

}  // namespace multitetra
