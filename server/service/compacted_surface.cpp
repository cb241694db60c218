#include "server/service/compacted_surface.hpp"

#include <utility>

#include "server/core/compaction_share.hpp"
#include "server/dataset/in_parallel.hpp"

namespace multitetra {

SurfaceOptions surface_options(const StepRequest& step) {
  SurfaceOptions options{.isovalue = step.request.isovalue,
                         .lattice_resolution = step.request.lattice_resolution};
  if (step.request.compact) options.max_triangles = kMaxTrianglesToCompact;
  return options;
}

void compact(TiledSurface& surface, const StepRequest& step, const DatasetInfo& info,
             const std::stop_token& stop) {
  if (!step.request.compact) return;
  const ThresholdMap thresholds(step.request, info);
  in_parallel(
      surface.tiles.size(),
      [&](std::size_t i) {
        TileMesh& tile = surface.tiles[i];
        Compacted small = compacted(
            tile.mesh, compaction_of(tile.cube, thresholds, step.request.lattice_resolution, info));
        tile.mesh = std::move(small.mesh);
        tile.compaction_bound = small.bound;
      },
      stop);
}

}  // namespace multitetra
