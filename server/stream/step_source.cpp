#include "server/stream/step_source.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "common/wire/messages.hpp"
#include "server/core/thresholds/threshold_map.hpp"
#include "server/dataset/in_parallel.hpp"
#include "server/extraction/reference_extractor.hpp"
#include "server/extraction/shading.hpp"
#include "server/extraction/surface_extractor.hpp"

namespace multitetra {
namespace {

// Everything that a step is a function of. Protobuf's bytes identify the request well enough within
// one process: equal requests that differed in their bytes would only be made twice.
std::string key_of(const StepRequest& step, const DatasetInfo& info) {
  return std::to_string(step.finest_spacing) + ' ' +
         serialize(OpenStream{
             .request_id = 1, .dataset = info.name, .request = step.request, .held = {}});
}

// The most important first: where the least error is allowed, which is near the eye or in the
// finest region.
void sort_by_importance(std::vector<EncodedTile>& tiles, const ThresholdMap& thresholds) {
  if (thresholds.least() == thresholds.largest()) return;
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    order.emplace_back(thresholds.least_in(box_of(tiles[i].summary.cube)), i);
  }
  std::sort(order.begin(), order.end());
  std::vector<EncodedTile> sorted;
  sorted.reserve(tiles.size());
  for (const auto& [threshold, index] : order) sorted.push_back(std::move(tiles[index]));
  tiles = std::move(sorted);
}

// On all threads; tiles that the cache has are not encoded again.
std::vector<EncodedTile> encode(const TiledSurface& surface, const Shading& shading,
                                TileCache& cache, const std::stop_token& stop) {
  std::vector<EncodedTile> encoded(surface.tiles.size());
  in_parallel(
      encoded.size(),
      [&](std::size_t i) {
        const TileMesh& tile = surface.tiles[i];
        const ContentDigest content = digest(tile.mesh);
        const TileKey key = {content, tile.cube, shading.appearance(), tile.simplification_bound};
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

ExtractedSteps::ExtractedSteps(std::shared_ptr<const SurfaceExtractor> extractor,
                               std::shared_ptr<StepCache> cache)
    : extractor_(std::move(extractor)),
      cache_(cache ? std::move(cache) : std::make_shared<StepCache>(0)) {}

const DatasetInfo& ExtractedSteps::info() const { return extractor_->dataset().info; }

EncodedStep ExtractedSteps::make(const StepRequest& step, std::stop_token stop) const {
  return cache_->get(key_of(step, info()), stop,
                     [&](const std::stop_token& all_stop) { return extract(step, all_stop); });
}

EncodedStep ExtractedSteps::extract(const StepRequest& step, const std::stop_token& stop) const {
  const TiledSurface surface = extractor_->extract(step, stop);
  const Shading shading(extractor_->dataset(), step);
  EncodedStep made{.tetrahedra = surface.tetrahedra,
                   .active_tetrahedra = surface.active_tetrahedra,
                   .tiles = encode(surface, shading, cache_->tiles(), stop),
                   .appearance = shading.appearance()};
  sort_by_importance(made.tiles, model_options(step, info(), stop).thresholds);
  return made;
}

StepSizes ExtractedSteps::sizes(std::stop_token stop, SizeAccuracy accuracy) const {
  return surface_sizes(*extractor_, std::move(stop), accuracy);
}

}  // namespace multitetra
