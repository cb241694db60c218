// Extraction on all threads: the grid is divided into octree cubes, whose surfaces are extracted
// independently by core and then joined.
#pragma once

#include <functional>
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

// The source of an extraction: a model of a field or of a prepared volume.
class CubeExtractor {
 public:
  virtual ~CubeExtractor() = default;
  // Announces that the surfaces in these cubes will be extracted next.
  virtual void will_extract(std::span<const OctreeCube> cubes) const { (void)cubes; }
  [[nodiscard]] virtual bool is_refined(const OctreeCube& cube) const = 0;
  // surface_in() and join() are called concurrently.
  [[nodiscard]] virtual CubeSurface surface_in(const OctreeCube& cube) const = 0;
  [[nodiscard]] virtual CubeSurface join(const OctreeCube& cube,
                                         std::vector<CubeSurface> children) const = 0;
};

// Returns the surface in `root`, extracted in cubes of 2^exponent steps. The result does not depend
// on the exponent or the number of threads. Throws Cancelled soon after `stop` is triggered. With
// `take`, the tiles are passed to it instead, each once it is complete.
[[nodiscard]] TiledMesh extract_in_parallel(const CubeExtractor& extractor, const OctreeCube& root,
                                            int exponent, std::stop_token stop,
                                            const TakeTile& take = nullptr);

}  // namespace multitetra
