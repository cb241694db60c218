#include "server/extraction/touching_extraction.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "common/base/in_parallel.hpp"
#include "server/core/planning/resolved_step.hpp"
#include "server/core/simplification/touching_surfaces.hpp"
#include "server/extraction/surface_extractor.hpp"

namespace multitetra {
namespace {

LatticeMesh full_resolution_surface(const DatasetPtr& dataset, const IsosurfaceRequest& request,
                                    const std::stop_token& stop) {
  const IsosurfaceRequest full = {.isovalue = request.isovalue,
                                  .error = 0,
                                  .lattice_resolution = request.lattice_resolution,
                                  .simplify = false};
  return weld(SurfaceExtractor(dataset).extract({.request = full}, stop).tiles,
              request.lattice_resolution);
}

void simplify(std::vector<SurfacePatch>& patches, const SimplificationOptions& options,
              const std::stop_token& stop) {
  // The largest first, so that no thread is left with one at the end.
  std::vector<std::size_t> order(patches.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return patches[a].mesh.triangles.size() > patches[b].mesh.triangles.size();
  });
  const auto simplify_one = [&](std::size_t i) {
    simplify_patch(patches, order[i], options, [&stop] { throw_if_stopped(stop); });
  };
  if (options.is_intersection_free) {
    for (std::size_t i = 0; i < order.size(); ++i) simplify_one(i);
  } else {
    in_parallel(order.size(), simplify_one, stop);
  }
}

}  // namespace

TouchingSurfaces extract_touching(std::span<const DatasetPtr> datasets,
                                  const IsosurfaceRequest& request, const std::stop_token& stop) {
  std::vector<LatticeMesh> surfaces;
  for (const DatasetPtr& dataset : datasets) {
    surfaces.push_back(full_resolution_surface(dataset, request, stop));
  }
  std::vector<SurfacePatch> patches = patches_of(surfaces);
  surfaces = {};
  if (request.simplify) {
    const ResolvedStep spec({.request = request}, datasets.front()->info);
    simplify(patches, spec.simplification(), stop);
  }
  TouchingSurfaces result;
  result.common_triangles.resize(datasets.size());
  for (const SurfacePatch& patch : patches) {
    if (patch.second == SurfacePatch::kNone) continue;
    for (const std::uint32_t surface : {patch.first, patch.second}) {
      result.common_triangles[surface] += patch.mesh.triangles.size();
    }
  }
  result.surfaces = joined_patches(patches, datasets.size());
  return result;
}

}  // namespace multitetra
