#include "server/service/surface_cache.hpp"

#include <utility>

namespace multitetra {

EncodedStep SurfaceCache::get(const std::string& key, const std::stop_token& stop,
                              const Make& make) {
  if (auto step = find_cached(key)) return *std::move(step);
  return flights_.get(key, stop, [&](const std::stop_token& all_stop) {
    EncodedStep step = make(all_stop);
    add(key, step);
    return step;
  });
}

bool SurfaceCache::is_cached(const std::string& key) {
  const std::lock_guard lock(mutex_);
  const Outline* const found = outlines_.find(key);
  return found != nullptr && tiles_.has_all(found->tiles);
}

std::optional<EncodedStep> SurfaceCache::find_cached(const std::string& key) {
  Outline outline;
  {
    const std::lock_guard lock(mutex_);
    const Outline* const found = outlines_.find(key);
    if (found == nullptr) return std::nullopt;
    outline = *found;
  }
  EncodedStep step = std::move(outline.step);
  step.tiles.reserve(outline.tiles.size());
  for (const TileKey& tile : outline.tiles) {
    auto found = tiles_.find(tile);
    if (!found) return std::nullopt;
    step.tiles.push_back(*std::move(found));
  }
  return step;
}

void SurfaceCache::add(const std::string& key, const EncodedStep& step) {
  Outline outline{.step = step, .tiles = {}};
  outline.step.tiles = {};
  outline.step.meshes = {};
  for (const EncodedTile& tile : step.tiles) {
    const TileKey of = {tile.summary.digest, tile.summary.cube, step.appearance,
                        tile.summary.simplification_bound, step.dataset};
    tiles_.add(of, tile);
    outline.tiles.push_back(of);
  }
  const std::size_t weight =
      sizeof(Outline) + 2 * key.size() + 128 + outline.tiles.size() * sizeof(TileKey);
  const std::lock_guard lock(mutex_);
  outlines_.add(key, std::move(outline), weight);
}

}  // namespace multitetra
