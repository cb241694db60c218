// Extraction on all threads: the grid is cut into octree cubes, which core extracts one by one, and
// their surfaces are joined.
#pragma once

#include <iterator>
#include <span>
#include <stop_token>
#include <utility>
#include <vector>

#include "common/base/in_parallel.hpp"
#include "server/core/errors/leaves.hpp"
#include "server/core/surface/tiling.hpp"
#include "server/extraction/tiled_surface.hpp"

namespace multitetra {

// The source of an extraction: a model over a field, or over a prepared volume.
class CubeExtractor {
 public:
  virtual ~CubeExtractor() = default;
  // The surfaces in these cubes are taken next.
  virtual void will_extract(std::span<const OctreeCube> cubes) const { (void)cubes; }
  [[nodiscard]] virtual bool is_refined(const OctreeCube& cube) const = 0;
  // Both are called by several threads at once.
  [[nodiscard]] virtual CubeSurface surface_in(const OctreeCube& cube) const = 0;
  [[nodiscard]] virtual CubeSurface join(const OctreeCube& cube,
                                         std::vector<CubeSurface> children) const = 0;
};

// The surface in `root`, extracted in cubes of 2^exponent steps. The same for any exponent and any
// number of threads. Throws Cancelled soon after `stop` is triggered.
[[nodiscard]] TiledSurface extract_in_parallel(const CubeExtractor& extractor,
                                               const OctreeCube& root, int exponent,
                                               std::stop_token stop);

}  // namespace multitetra
