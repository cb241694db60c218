// The source of a dataset's surfaces: for planning streams a dataset is what makes steps.
#pragma once

#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "common/mesh/mesh.hpp"
#include "common/request/dataset_info.hpp"
#include "common/wire/tile.hpp"
#include "server/core/planning/refinement_plan.hpp"
#include "server/core/spectrum/prepared_volume.hpp"
#include "server/extraction/surface_sizes.hpp"

namespace multitetra {

// A complete conforming model in tiles: encoded to be sent, or as meshes to be used in this
// process.
struct TiledStep {
  // Tetrahedra of the model.
  std::uint64_t tetrahedra = 0;
  // Those that the surface crosses.
  std::uint64_t active_tetrahedra = 0;
  std::vector<EncodedTile> tiles;  // In the order they are sent.
  std::uint64_t appearance = 0;    // As in TileKey,
  // As in TileKey.
  std::string dataset = {};
  std::uint32_t crossed_octants = 0;  // As in StepBegin.
  bool is_in_shells = false;
  // With a budget and simplification: the least threshold that the budget needed.
  double at_least = 0;
  // Either none, or one a tile, whose payload is null then. Its normals are what decoding gives.
  std::vector<std::shared_ptr<const LatticeMesh>> meshes = {};
};

// The size of all tiles together; meshes have no bytes.
[[nodiscard]] SurfaceSize size_of(const TiledStep& step);

// Immutable as seen from outside, and used by all clients at once. What it takes long for throws
// Cancelled (of in_parallel.hpp) soon after `stop` is triggered.
class SurfaceProvider {
 public:
  virtual ~SurfaceProvider() = default;

  [[nodiscard]] virtual const DatasetInfo& info() const = 0;

  // Requires a validated request. The same step gives the same tiles, on any thread. A simplified
  // final step keeps to its request's budget, or is the coarsest that there is.
  [[nodiscard]] virtual TiledStep make(const StepRequest& step, std::stop_token stop) const = 0;
  // The same, with meshes where that is less work than encoded tiles.
  [[nodiscard]] virtual TiledStep make_meshes(const StepRequest& step, std::stop_token stop) const {
    return make(step, std::move(stop));
  }
  // Whether make() has this step in a cache, as far as known.
  [[nodiscard]] virtual bool remembers(const StepRequest&) const { return false; }
  // Size estimates of steps; valid while the provider lives.
  [[nodiscard]] virtual SizeEstimates sizes(std::stop_token stop, SizeAccuracy accuracy) const = 0;
  // The costs of steps on this machine, without the link.
  [[nodiscard]] virtual CostEstimates costs() const { return {}; }
  // The samples, while the provider lives; null where they are not here.
  [[nodiscard]] virtual const PreparedVolume* volume() const { return nullptr; }
  // Whether steps may have sample shells for the clients of its catalogue. Without a volume here:
  // whether the servers that make the steps send shells to these clients.
  [[nodiscard]] virtual bool sends_shells() const { return true; }
};

}  // namespace multitetra
