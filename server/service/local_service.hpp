// The service by the workers of this process.
//
// A step of a stream is made only after the messages of the previous one were sent. At most one
// step per caller is with the workers, even when streams supersede each other; previews of several
// datasets are made in groups, as one step. Workers never wait for a client, and touch only what
// makes the step; everything else runs on the executor's thread.
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
  std::size_t workers = 2;  // Number of worker threads, at least 1.
  ServiceLimits limits = {};
  RequestLimits requests = {};
  std::shared_ptr<SurfaceCache> cache = nullptr;  // For find_tile().
  // Block statistics of remote datasets for the metrics. May be empty.
  std::function<BlockState()> blocks = {};
};

class LocalService : public SurfaceService {
 public:
  LocalService(asio::any_io_executor executor, CataloguePtr catalogue, LocalServiceOptions options);
  ~LocalService() override;

  void join() override { workers_.join(); }
  [[nodiscard]] ServiceState state() const override;
  [[nodiscard]] ServiceClientPtr open(ConnectionContextPtr client) override;
  [[nodiscard]] std::optional<TileCache::Found> find_tile(
      const ContentDigest& digest, const TileCache::MaySee& may_see) override;

  // Replaces the catalogue for later requests. Call on the executor's thread.
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
