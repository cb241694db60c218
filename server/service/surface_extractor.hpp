// The isosurface of a dataset for one step, cut into tiles: the pure parts of core, run on all
// threads.
#pragma once

#include <cstdint>
#include <memory>
#include <stop_token>
#include <vector>

#include "common/mesh.hpp"
#include "common/octree_cube.hpp"
#include "common/tile.hpp"
#include "server/core/refinement_plan.hpp"
#include "server/dataset/dataset.hpp"

namespace multitetra {

struct TileMesh {
  OctreeCube cube;
  LatticeMesh mesh;  // At least one triangle.
};

struct TiledSurface {
  std::uint64_t tetrahedra = 0;         // Of the model.
  std::uint64_t active_tetrahedra = 0;  // Of them crossed by the surface.
  std::vector<TileMesh> tiles;          // Sorted by cube; the same for any number of threads.
};

// Thrown by long work whose stop token was triggered.
struct Cancelled {};

// Safe to use from several threads at once.
class SurfaceExtractor {
 public:
  explicit SurfaceExtractor(DatasetPtr dataset);
  ~SurfaceExtractor();

  [[nodiscard]] const Dataset& dataset() const { return *dataset_; }

  // Requires a validated request. Throws Cancelled soon after `stop` is triggered.
  [[nodiscard]] TiledSurface extract(const StepRequest& step, std::stop_token stop = {}) const;

 private:
  class ErrorsCache;
  DatasetPtr dataset_;
  std::unique_ptr<ErrorsCache> errors_;
};

// The tiles as Draco bytes, in the same order, encoded on all threads.
[[nodiscard]] std::vector<EncodedTile> encode_tiles(const TiledSurface& surface,
                                                    std::stop_token stop = {});

}  // namespace multitetra
