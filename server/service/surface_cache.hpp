// A cache of steps, so that clients share previews and surfaces of popular isovalues.
//
// A step is cached as the list of its tiles; the TileCache holds the tiles, shared between steps. A
// step with an evicted tile is made again from the remaining ones.
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

// Thread-safe.
class SurfaceCache {
 public:
  // Caches tiles and steps of at most `capacity` bytes together. 0 caches nothing, but concurrent
  // equal requests still share one computation.
  explicit SurfaceCache(std::size_t capacity)
      : tiles_(capacity - capacity / 16), outlines_(capacity / 16) {}

  using Make = std::function<EncodedStep(std::stop_token)>;
  // Returns the step of that key, calling `make` unless it is cached or being made. A key must
  // always identify the same step. Throws what `make` throws, and Cancelled soon after `stop` is
  // triggered.
  [[nodiscard]] EncodedStep get(const std::string& key, const std::stop_token& stop,
                                const Make& make);

  // Returns whether get() would find the step in the cache.
  [[nodiscard]] bool is_cached(const std::string& key);

  [[nodiscard]] TileCache& tiles() { return tiles_; }

 private:
  struct Outline {
    // Its tiles and meshes are empty.
    EncodedStep step;
    std::vector<TileKey> tiles;
  };
  [[nodiscard]] std::optional<EncodedStep> find_cached(const std::string& key);
  void add(const std::string& key, const EncodedStep& step);

  TileCache tiles_;
  SingleFlight<std::string, EncodedStep> flights_;
  std::mutex mutex_;  // Guards outlines_.
  LruMap<std::string, Outline> outlines_;
};

}  // namespace multitetra
