#include "server/service/caching_surface_provider.hpp"

#include <algorithm>
#include <functional>
#include <string>
#include <utility>

#include "common/base/in_parallel.hpp"
#include "server/core/planning/budget.hpp"
#include "server/core/planning/resolved_step.hpp"
#include "server/core/spectrum/crossed_octants.hpp"
#include "server/extraction/budgeted_surface.hpp"
#include "server/extraction/normal_encoder.hpp"
#include "server/extraction/reference_extractor.hpp"
#include "server/extraction/shell_extractor.hpp"
#include "server/extraction/surface_extractor.hpp"

namespace multitetra {
namespace {

void sort_by_importance(std::vector<EncodedTile>& tiles, const ResolvedStep& spec) {
  if (!spec.has_send_order()) return;
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    order.emplace_back(spec.send_order(tiles[i].summary.cube), i);
  }
  std::sort(order.begin(), order.end());
  std::vector<EncodedTile> sorted;
  sorted.reserve(tiles.size());
  for (const auto& [send_order, index] : order) sorted.push_back(std::move(tiles[index]));
  tiles = std::move(sorted);
}

// Encodes the tiles that are not in the cache, on all threads.
std::vector<EncodedTile> encode(const TiledMesh& surface, const NormalEncoder& normals,
                                const std::string& dataset, TileCache& cache,
                                const std::stop_token& stop) {
  std::vector<EncodedTile> encoded(surface.tiles.size());
  in_parallel(
      encoded.size(),
      [&](std::size_t i) {
        const TileMesh& tile = surface.tiles[i];
        const ContentDigest content = digest(tile.mesh);
        const TileKey key = {content, tile.cube, normals.appearance(), tile.simplification_bound,
                             dataset};
        if (auto known = cache.find(key)) {
          encoded[i] = *std::move(known);
        } else {
          encoded[i] = normals.encoded(tile, content);
          encoded[i].summary.simplification_bound = tile.simplification_bound;
          cache.add(key, encoded[i]);
        }
      },
      stop);
  return encoded;
}

// Adds the tiles as meshes, without payloads, on all threads.
void add_meshes(EncodedStep& step, TiledMesh surface, const NormalEncoder& normals,
                const std::stop_token& stop) {
  step.tiles.resize(surface.tiles.size());
  step.meshes.resize(surface.tiles.size());
  in_parallel(
      surface.tiles.size(),
      [&](std::size_t i) {
        TileMesh& tile = surface.tiles[i];
        tile.mesh.normals = normals.decoded_normals(tile);
        step.tiles[i].summary = {
            .cube = tile.cube,
            .digest = digest(tile.mesh),
            .triangles = static_cast<std::uint32_t>(tile.mesh.triangles.size()),
            .vertices = static_cast<std::uint32_t>(tile.mesh.vertices.size()),
            .simplification_bound = tile.simplification_bound};
        step.meshes[i] = std::make_shared<const LatticeMesh>(std::move(tile.mesh));
      },
      stop);
}

}  // namespace

CachingSurfaceProvider::CachingSurfaceProvider(std::shared_ptr<const SurfaceExtractor> extractor,
                                               std::shared_ptr<SurfaceCache> cache)
    : extractor_(std::move(extractor)),
      cache_(cache ? std::move(cache) : std::make_shared<SurfaceCache>(0)) {}

const DatasetInfo& CachingSurfaceProvider::info() const { return extractor_->dataset().info; }

EncodedStep CachingSurfaceProvider::make(const StepRequest& step, std::stop_token stop) const {
  const std::string key = key_of(step, info());
  if (!step.shell) {
    return cache_->get(key, stop, [&](const std::stop_token& all_stop) {
      return extract(step, TileForm::kEncoded, all_stop);
    });
  }
  EncodedStep made = cache_->get(key, stop, [&](const std::stop_token& all_stop) {
    return extract_in_shells(step, all_stop);
  });
  // The cached step is in another order, as importance depends on the request.
  sort_by_importance(made.tiles, resolved_step(step, info(), stop));
  return made;
}

EncodedStep CachingSurfaceProvider::extract_in_shells(const StepRequest& step,
                                                      const std::stop_token& stop) const {
  const Clock::time_point start = Clock::now();
  EncodedStep made{.tiles = extract_shells(extractor_->dataset(), level_of(step), stop),
                   .appearance = kShellAppearance,
                   .dataset = info().name,
                   .is_in_shells = true};
  record_costs(step, made, start);
  return made;
}

EncodedStep CachingSurfaceProvider::make_meshes(const StepRequest& step,
                                                std::stop_token stop) const {
  if (is_cached(step)) return make(step, std::move(stop));
  return meshes_.get(key_of(step, info()), stop, [&](const std::stop_token& all_stop) {
    return extract(step, TileForm::kMesh, all_stop);
  });
}

bool CachingSurfaceProvider::is_cached(const StepRequest& step) const {
  return cache_->is_cached(key_of(step, info()));
}

EncodedStep CachingSurfaceProvider::extract(const StepRequest& step, TileForm form,
                                            const std::stop_token& stop) const {
  const Clock::time_point start = Clock::now();
  const ResolvedStep spec = resolved_step(step, info(), stop);
  const NormalEncoder normals(extractor_->dataset(), step);
  EncodedStep made{.tiles = {}, .appearance = normals.appearance(), .dataset = info().name};
  const auto encoded = [&](const TiledMesh& surface) {
    return encode(surface, normals, info().name, cache_->tiles(), stop);
  };
  TiledMesh surface;
  if (has_own_budget(step)) {
    const auto bytes_of = [&](const TiledMesh& candidate) {
      made.tiles = encoded(candidate);
      return size_of(made).bytes;
    };
    BudgetedSurface within = surface_within_budget(*extractor_, step.request, bytes_of, stop);
    surface = std::move(within.surface);
    made.error_floor = within.error_floor;
  } else {
    surface = extractor_->extract(spec, stop);
  }
  made.tetrahedra = surface.tetrahedra;
  made.active_tetrahedra = surface.active_tetrahedra;
  if (form == TileForm::kEncoded) {
    if (made.tiles.empty()) made.tiles = encoded(surface);
    sort_by_importance(made.tiles, spec);
  } else {
    add_meshes(made, std::move(surface), normals, stop);
  }
  if (const auto& cell = step.request.cell) {
    made.crossed_octants =
        crossed_octants(extractor_->dataset(), cell->cube, step.request.isovalue);
  }
  if (extractor_->dataset().check) extractor_->dataset().check();
  record_costs(step, made, start);
  return made;
}

void CachingSurfaceProvider::record_costs(const StepRequest& step, const EncodedStep& made,
                                          Clock::time_point start) const {
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
  const std::lock_guard lock(costs_mutex_);
  costs_.record(form_of(step), size_of(made).extracted, seconds);
}

CostEstimates CachingSurfaceProvider::costs() const {
  const std::lock_guard lock(costs_mutex_);
  return costs_.costs();
}

const PreparedVolume* CachingSurfaceProvider::volume() const { return &extractor_->dataset(); }

SizeEstimates CachingSurfaceProvider::sizes(std::stop_token stop, SizeAccuracy accuracy) const {
  SizeEstimates sizes = surface_sizes(*extractor_, std::move(stop), accuracy);
  const std::function<void()> check = extractor_->dataset().check;
  if (!check) return sizes;
  return {.of =
              [of = std::move(sizes.of), check](const StepRequest& step) {
                const SurfaceSize size = of(step);
                check();
                return size;
              },
          .rough =
              [rough = std::move(sizes.rough), check](const IsosurfaceRequest& request) {
                const SurfaceSize size = rough(request);
                check();
                return size;
              },
          .to_fetch = std::move(sizes.to_fetch)};
}

}  // namespace multitetra
