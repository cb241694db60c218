// The service of this process: its workers answer.
//
// A step of a stream is made only when the messages of the one before have gone. At most one step
// of a caller's stream is with the workers, also when streams supersede each other. Workers never
// wait for a client, and touch only what makes the step; everything else happens on the executor's
// thread.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

#include "server/service/dataset_catalogue.hpp"
#include "server/service/service_limits.hpp"
#include "server/service/surface_cache.hpp"
#include "server/service/surface_service.hpp"
#include "server/service/workers.hpp"

namespace multitetra {

struct LocalServiceOptions {
  std::size_t workers = 2;  // Steps that are made at the same time, at least 1.
  ServiceLimits limits = {};
  RequestLimits requests = {};
  std::shared_ptr<SurfaceCache> cache = nullptr;  // Whose tiles are found by their digest.
  // Blocks of remote datasets, for the metrics. May be empty.
  std::function<BlockState()> blocks = {};
};

class LocalService : public SurfaceService {
 public:
  LocalService(asio::any_io_executor executor, CataloguePtr catalogue, LocalServiceOptions options);
  ~LocalService() override;

  void join() override { workers_.join(); }
  [[nodiscard]] ServiceState state() const override;
  [[nodiscard]] CallerPtr open(ConnectionContextPtr client) override;
  [[nodiscard]] std::optional<TileCache::Found> find_tile(
      const ContentDigest& digest, const TileCache::MaySee& may_see) override;

  // On the executor's thread: replaces the catalogue for later requests.
  void offer(CataloguePtr catalogue) { catalogue_ = std::move(catalogue); }
  [[nodiscard]] const CataloguePtr& catalogue() const { return catalogue_; }
  [[nodiscard]] Workers& workers() { return workers_; }
  [[nodiscard]] const LocalServiceOptions& options() const { return options_; }
  [[nodiscard]] const asio::any_io_executor& executor() const { return executor_; }

 private:
  asio::any_io_executor executor_;
  CataloguePtr catalogue_;
  LocalServiceOptions options_;
  Workers workers_;
};

}  // namespace multitetra
