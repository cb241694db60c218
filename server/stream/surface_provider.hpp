// The interface through which streams obtain the steps of a dataset.
#pragma once

#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "common/dataset/dataset_info.hpp"
#include "common/mesh/mesh.hpp"
#include "common/wire/tile.hpp"
#include "server/core/planning/refinement_plan.hpp"
#include "server/core/spectrum/prepared_volume.hpp"
#include "server/extraction/surface_sizes.hpp"
#include "server/stream/coarsest_sizes.hpp"

namespace multitetra {

// A complete conforming model in tiles: encoded for sending, or as meshes for use in this process.
struct EncodedStep {
  // Tetrahedra of the model.
  std::uint64_t tetrahedra = 0;
  // Tetrahedra that the surface crosses.
  std::uint64_t active_tetrahedra = 0;
  std::vector<EncodedTile> tiles;  // In the order of sending.
  // The appearance and the dataset of the tiles' keys: see TileKey.
  std::uint64_t appearance = 0;
  std::string dataset = {};
  std::uint32_t crossed_octants = 0;  // See StepBegin.
  bool is_in_shells = false;
  // With a budget and simplification: the smallest floor of thresholds that the budget required.
  double error_floor = 0;
  // Empty, or one per tile, whose payload is then null. Normals are as decoded.
  std::vector<std::shared_ptr<const LatticeMesh>> meshes = {};
};

// Returns the total size of all tiles; meshes have no bytes.
[[nodiscard]] SurfaceSize size_of(const EncodedStep& step);

// Logically immutable and thread-safe; shared by all clients. Long operations throw Cancelled
// (in_parallel.hpp) soon after `stop` is triggered.
class SurfaceProvider {
 public:
  virtual ~SurfaceProvider() = default;

  [[nodiscard]] virtual const DatasetInfo& info() const = 0;

  // Builds a step. Requires a validated request. The same step gives the same tiles, on any thread.
  // A simplified final step is within its request's budget, or is the coarsest possible one.
  [[nodiscard]] virtual EncodedStep make(const StepRequest& step, std::stop_token stop) const = 0;
  // Builds the same step, with meshes where these are cheaper than encoded tiles.
  [[nodiscard]] virtual EncodedStep make_meshes(const StepRequest& step,
                                                std::stop_token stop) const {
    return make(step, std::move(stop));
  }
  // Returns whether make() is known to have this step in a cache.
  [[nodiscard]] virtual bool is_cached(const StepRequest&) const { return false; }
  // Returns size estimates of steps; valid while the provider lives.
  [[nodiscard]] virtual SizeEstimates sizes(std::stop_token stop, SizeAccuracy accuracy) const = 0;
  // Returns the costs of steps on this machine, without the link.
  [[nodiscard]] virtual CostEstimates costs() const { return {}; }
  // Returns the volume, valid while the provider lives; null if it is not on this server.
  [[nodiscard]] virtual const PreparedVolume* volume() const { return nullptr; }
  // Returns whether steps may have sample shells for the clients of its catalogue. Without a local
  // volume: whether the upstream servers send shells to these clients.
  [[nodiscard]] virtual bool sends_shells() const { return true; }

  [[nodiscard]] CoarsestSizesCache& coarsest_sizes() const { return *coarsest_sizes_; }

 private:
  // Shared with copies, which are of the same dataset.
  std::shared_ptr<CoarsestSizesCache> coarsest_sizes_ = std::make_shared<CoarsestSizesCache>();
};

}  // namespace multitetra
