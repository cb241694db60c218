// A cache of steps: previews of popular isovalues, one surface for many clients at once.
//
// A step is cached as the list of its tiles; the tiles themselves lie in the TileCache, where steps
// share them. A step with an evicted tile is made again, using the remaining ones.
#pragma once

#include <cstddef>
#include <functional>
#include <mutex>
#include <stop_token>
#include <string>
#include <vector>

#include "common/base/lru_map.hpp"
#include "server/service/detail/single_flight.hpp"
#include "server/service/tile_cache.hpp"
#include "server/stream/surface_provider.hpp"

namespace multitetra {

// Safe to use from several threads at once.
class SurfaceCache {
 public:
  // Caches tiles and steps of at most `capacity` bytes together; 0 caches nothing, and equal
  // requests at the same time are still made once.
  explicit SurfaceCache(std::size_t capacity)
      : tiles_(capacity - capacity / 16), outlines_(capacity / 16) {}

  using Make = std::function<TiledStep(std::stop_token)>;
  // The step of that key, made by `make` unless it is remembered or being made; the same key always
  // stands for the same step. Throws what `make` throws, and Cancelled soon after `stop` is
  // triggered.
  [[nodiscard]] TiledStep get(const std::string& key, const std::stop_token& stop,
                              const Make& make);

  // Whether get() would have it at once.
  [[nodiscard]] bool remembers(const std::string& key);

  [[nodiscard]] TileCache& tiles() { return tiles_; }

 private:
  struct Outline {
    TiledStep step;  // Without its tiles and meshes.
    std::vector<TileKey> tiles;
  };
  [[nodiscard]] std::optional<TiledStep> remembered(const std::string& key);
  void remember(const std::string& key, const TiledStep& step);

  TileCache tiles_;
  SingleFlight<std::string, TiledStep> flights_;
  std::mutex mutex_;  // Guards outlines_.
  LruMap<std::string, Outline> outlines_;
};

}  // namespace multitetra
