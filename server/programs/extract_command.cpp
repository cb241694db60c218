#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "common/base/exit_codes.hpp"
#include "common/mesh/content_digest.hpp"
#include "common/request/request_notices.hpp"
#include "server/core/planning/budget.hpp"
#include "server/dataset/dataset.hpp"
#include "server/extraction/normal_encoder.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "server/extraction/touching_extraction.hpp"
#include "server/programs/commands.hpp"
#include "server/programs/local_output.hpp"
#include "server/programs/thread_options.hpp"
#include "server/service/caching_surface_provider.hpp"
#include "server/service/surface_steps.hpp"

namespace multitetra {
namespace {

// ---- a folder: the surfaces of all its datasets, such as the labels of a segmentation

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

// Writes one GLB with a node for each dataset if they are of one time; otherwise a file for each
// dataset, with the dataset's name in its own, but none without any triangle. Returns the exit
// code. Throws ExitError (kUsage) if the datasets have different grids or the request has options
// for one dataset, (kEmptySurface) if all surfaces are empty.
int extract_folder(const LocalArguments& arguments) {
  Progress progress("extract", 4, arguments.output.quiet || arguments.output.json);
  progress.begin("open");
  const std::vector<DatasetPtr> datasets = opened(arguments.dataset);
  const DatasetInfo& first = datasets.front()->info;
  const Result<IsosurfaceRequest> request = request_of(arguments.surface, first);
  if (!request) throw std::invalid_argument(request.error().text);
  require_folder_request(*request);
  std::vector<const DatasetInfo*> infos;
  for (const DatasetPtr& dataset : datasets) infos.push_back(&dataset->info);
  const std::vector<std::string> files = files_of(
      arguments.output.file, mesh_format_of(arguments.output.file, arguments.surface), infos);
  require_outputs_of(files, arguments.output,
                     {{"--threshold-grid", arguments.surface.threshold_grid},
                      {"--color-by", arguments.surface.query.color_by}});
  LocalOutput output(arguments, progress);
  output.notices().add(request_notices(*request, first));
  progress.begin("surfaces");
  TouchingSurfaces extracted = extract_by_time(datasets, *request);
  progress.begin("checks");
  for (std::size_t i = 0; i < datasets.size(); ++i) {
    Simplified& simplified = extracted.surfaces[i];
    const ContentDigest content = digest(simplified.mesh);
    output.add({.request = *request,
                .mesh = std::move(simplified.mesh),
                .whole = {.simplification_bound = simplified.bound, .digest = content},
                .common_triangles = extracted.common_triangles[i]},
               *infos[i], files[i], surface_name(*infos[i]), /*names_itself=*/true);
  }
  output.write(/*may_lack_some=*/true);
  return output.report();
}

// ---- one dataset

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
  surface.mesh.normals = rounded_normals(extractor->dataset(), surface.mesh, request.normal_bits,
                                         NormalSource::kSamples);
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
