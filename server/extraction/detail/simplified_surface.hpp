// A surface that is simplified, as far as its step allows: on all threads.
#pragma once

#include <cstddef>
#include <stop_token>
#include <vector>

#include "server/core/planning/resolved_step.hpp"
#include "server/core/simplification/simplified_cube.hpp"
#include "server/extraction/tiled_surface.hpp"

namespace multitetra {

// In seconds of the processor: of all joins, and of the longest chain of joins that wait for each
// other, which no number of threads makes shorter.
struct SimplificationWork {
  double seconds = 0;
  double longest_chain = 0;
};

// The surface in one cube of 2^exponent steps a side, such as the whole grid, while it is
// simplified. All is the same for any number of threads.
class SurfaceSimplifier {
 public:
  SurfaceSimplifier(std::vector<TileMesh> tiles, const Vec3& lattice_step, int root_exponent);

  // Simplifies the tiles and cuts the surface into tiles again. May be called again with larger
  // distances if all calls before had `goes_on`: the bound stays one to the surface before anything
  // was simplified. Throws Cancelled soon after `stop` is triggered.
  SimplificationWork simplify(const SimplificationOptions& options, const std::stop_token& stop,
                              const SimplifiedTileLimits& limits = {});

  [[nodiscard]] std::size_t triangles() const;
  // With `goes_on` the last collapses of the last call may be undone, until the tiles have as many
  // triangles as `most` allows.
  [[nodiscard]] std::vector<TileMesh> tiles(std::size_t most = 0) const;

 private:
  int root_exponent_;
  std::vector<SimplifiedTile> tiles_;
};

// Simplifies a surface as far as the step says so.
void simplify(TiledSurface& surface, const ResolvedStep& spec, int root_exponent,
              const std::stop_token& stop);

}  // namespace multitetra
