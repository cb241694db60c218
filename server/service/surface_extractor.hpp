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
#include "server/core/error_based_model.hpp"
#include "server/core/field.hpp"
#include "server/core/refinement_plan.hpp"
#include "server/core/tiling.hpp"
#include "server/dataset/dataset.hpp"
#include "server/dataset/in_parallel.hpp"
#include "server/service/errors_cache.hpp"

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

inline constexpr std::size_t kDefaultErrorsCacheBytes = std::size_t{1} << 30;

// Safe to use from several threads at once.
class SurfaceExtractor {
 public:
  // Extractors may share a cache as long as all of them live; without one each has its own.
  explicit SurfaceExtractor(DatasetPtr dataset, std::shared_ptr<ErrorsCache> cache = nullptr);
  SurfaceExtractor(const SurfaceExtractor&) = delete;  // The cache knows the field by its address.
  SurfaceExtractor& operator=(const SurfaceExtractor&) = delete;

  [[nodiscard]] const Dataset& dataset() const { return *dataset_; }
  [[nodiscard]] const Field& field() const { return field_; }

  // The error-based model of a step: a pass over the volume where the isovalue's errors are not
  // known yet. Requires a validated request. Throws Cancelled soon after `stop` is triggered.
  [[nodiscard]] std::shared_ptr<const Model> model(const StepRequest& step,
                                                   std::stop_token stop = {}) const;

  // The isosurface of any model of this dataset's grid. Throws Cancelled as above.
  [[nodiscard]] TiledSurface surface(const Model& model, const SurfaceOptions& options,
                                     std::stop_token stop = {}) const;

  // Both at once.
  [[nodiscard]] TiledSurface extract(const StepRequest& step, std::stop_token stop = {}) const;

 private:
  DatasetPtr dataset_;
  Field field_;
  std::shared_ptr<ErrorsCache> errors_;
};

// The tiles as Draco bytes, in the same order, encoded on all threads.
[[nodiscard]] std::vector<EncodedTile> encode_tiles(const TiledSurface& surface,
                                                    std::stop_token stop = {});

}  // namespace multitetra
