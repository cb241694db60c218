#include "server/stream/step_source.hpp"

#include <algorithm>
#include <chrono>
#include <functional>
#include <string>
#include <utility>

#include "server/core/planning/step_spec.hpp"
#include "server/core/planning/surface_size.hpp"
#include "server/core/spectrum/crossed_octants.hpp"
#include "server/dataset/in_parallel.hpp"
#include "server/extraction/reference_extractor.hpp"
#include "server/extraction/shading.hpp"
#include "server/extraction/surface_extractor.hpp"

namespace multitetra {
namespace {

void sort_by_importance(std::vector<EncodedTile>& tiles, const StepSpec& spec) {
  if (!spec.has_important_places()) return;
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    order.emplace_back(spec.importance(tiles[i].summary.cube), i);
  }
  std::sort(order.begin(), order.end());
  std::vector<EncodedTile> sorted;
  sorted.reserve(tiles.size());
  for (const auto& [importance, index] : order) sorted.push_back(std::move(tiles[index]));
  tiles = std::move(sorted);
}

// On all threads; tiles that the cache has are not encoded again.
std::vector<EncodedTile> encode(const TiledSurface& surface, const Shading& shading,
                                const std::string& dataset, TileCache& cache,
                                const std::stop_token& stop) {
  std::vector<EncodedTile> encoded(surface.tiles.size());
  in_parallel(
      encoded.size(),
      [&](std::size_t i) {
        const TileMesh& tile = surface.tiles[i];
        const ContentDigest content = digest(tile.mesh);
        const TileKey key = {content, tile.cube, shading.appearance(), tile.simplification_bound,
                             dataset};
        if (auto known = cache.find(key)) {
          encoded[i] = *std::move(known);
        } else {
          encoded[i] = shading.encoded(tile, content);
          encoded[i].summary.simplification_bound = tile.simplification_bound;
          cache.add(key, encoded[i]);
        }
      },
      stop);
  return encoded;
}

}  // namespace

SurfaceSize size_of(const EncodedStep& step) {
  SurfaceSize size;
  for (const EncodedTile& tile : step.tiles) {
    size.triangles += tile.summary.triangles;
    size.bytes += tile.summary.bytes;
  }
  size.extracted = kTrianglesATetrahedron * static_cast<double>(step.active_tetrahedra);
  return size;
}

ExtractedSteps::ExtractedSteps(std::shared_ptr<const SurfaceExtractor> extractor,
                               std::shared_ptr<StepCache> cache)
    : extractor_(std::move(extractor)),
      cache_(cache ? std::move(cache) : std::make_shared<StepCache>(0)) {}

const DatasetInfo& ExtractedSteps::info() const { return extractor_->dataset().info; }

EncodedStep ExtractedSteps::make(const StepRequest& step, std::stop_token stop) const {
  return cache_->get(key_of(step, info()), stop,
                     [&](const std::stop_token& all_stop) { return extract(step, all_stop); });
}

bool ExtractedSteps::remembers(const StepRequest& step) const {
  return cache_->remembers(key_of(step, info()));
}

EncodedStep ExtractedSteps::extract(const StepRequest& step, const std::stop_token& stop) const {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  const StepSpec spec = step_spec(step, info(), stop);
  const TiledSurface surface = extractor_->extract(spec, stop);
  const Shading shading(extractor_->dataset(), step);
  EncodedStep made{.tetrahedra = surface.tetrahedra,
                   .active_tetrahedra = surface.active_tetrahedra,
                   .tiles = encode(surface, shading, info().name, cache_->tiles(), stop),
                   .appearance = shading.appearance(),
                   .dataset = info().name};
  if (const auto& cell = step.request.cell) {
    made.crossed_octants =
        crossed_octants(extractor_->dataset(), cell->cube, step.request.isovalue);
  }
  if (extractor_->dataset().check) extractor_->dataset().check();
  sort_by_importance(made.tiles, spec);
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
  const std::lock_guard lock(costs_mutex_);
  costs_.note(step.request.simplify, size_of(made).extracted, seconds);
  return made;
}

StepCosts ExtractedSteps::costs() const {
  const std::lock_guard lock(costs_mutex_);
  return costs_.costs();
}

const PreparedVolume* ExtractedSteps::volume() const { return &extractor_->dataset(); }

StepSizes ExtractedSteps::sizes(std::stop_token stop, SizeAccuracy accuracy) const {
  StepSizes sizes = surface_sizes(*extractor_, std::move(stop), accuracy);
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
