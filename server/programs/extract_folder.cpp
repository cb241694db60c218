#include "server/programs/extract_folder.hpp"

#include <map>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "common/base/exit_codes.hpp"
#include "common/mesh/content_digest.hpp"
#include "common/request/request_notices.hpp"
#include "server/extraction/touching_extraction.hpp"

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

}  // namespace

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

}  // namespace multitetra
