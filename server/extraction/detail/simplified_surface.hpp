// Simplification of a surface on all threads, as far as its step allows.
#pragma once

#include <cstddef>
#include <functional>
#include <mutex>
#include <stop_token>
#include <vector>

#include "server/core/planning/resolved_step.hpp"
#include "server/core/simplification/simplified_cube.hpp"
#include "server/extraction/tiled_surface.hpp"

namespace multitetra {

// Processor time in seconds: of all joins, and of the longest chain of dependent joins, which
// bounds the time with any number of threads.
struct SimplificationWork {
  double seconds = 0;
  double longest_chain = 0;
};

// Simplifies the surface in one cube of 2^exponent steps a side, such as the whole grid. Results do
// not depend on the number of threads.
class SurfaceSimplifier {
 public:
  SurfaceSimplifier(const Vec3& lattice_step, int root_exponent)
      : lattice_step_(lattice_step), root_exponent_(root_exponent) {}

  // Adds a tile and runs its first stage, unless that depends on other tiles. Thread-safe. Throws
  // Cancelled as below.
  void add(TileMesh tile, const SimplificationOptions& options, const std::stop_token& stop);

  // Simplifies the tiles and divides the surface into tiles again. Can be called again with larger
  // distances if all previous calls had `is_resumable`: the bound remains one to the original
  // surface. Throws Cancelled soon after `stop` is triggered.
  SimplificationWork simplify(const SimplificationOptions& options, const std::stop_token& stop,
                              const SimplifiedTileLimits& limits = {});

  [[nodiscard]] std::size_t triangles() const;
  // Returns the tiles. With `is_resumable`, undoes the last collapses as far as `max_triangles`
  // triangles allow.
  [[nodiscard]] std::vector<TileMesh> tiles(std::size_t max_triangles = 0) const;

 private:
  Vec3 lattice_step_;
  int root_exponent_;
  std::mutex mutex_;  // Guards tiles_ in add().
  std::vector<SimplifiedTile> tiles_;
};

// Returns the surface that `extract` makes, simplified as its step requests. The first stage runs
// while it is extracted, so that it is never in memory unsimplified. `extract` may get no function.
[[nodiscard]] TiledMesh extract_simplified(
    const ResolvedStep& spec, int root_exponent, const std::stop_token& stop,
    const std::function<TiledMesh(const TakeTile&)>& extract);

}  // namespace multitetra
