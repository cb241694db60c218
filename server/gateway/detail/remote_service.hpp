// The service of other servers: a client is offered their datasets together; streams and queries
// are forwarded. When a server is lost in the middle of a stream, another one with the same dataset
// continues, and the client notices only a pause.
//
// Memory is bounded: a few messages wait for the client, the following ones in the socket of the
// upstream (back-pressure).
#pragma once

#include <memory>

#include "server/gateway/detail/upstream_pool.hpp"
#include "server/service/surface_service.hpp"
#include "server/service/workers.hpp"

namespace multitetra {

class RemoteService : public SurfaceService {
 public:
  RemoteService(asio::any_io_executor executor, std::shared_ptr<UpstreamPool> upstreams,
                RequestLimits limits);
  ~RemoteService() override;

  [[nodiscard]] CallerPtr open(ConnectionContextPtr client) override;
  [[nodiscard]] std::optional<TileCache::Found> find_tile(
      const ContentDigest& digest, const TileCache::MaySee& may_see) override;
  [[nodiscard]] bool is_ready() const override { return upstreams_->is_ready(); }
  // Ends its threads. No call may follow.
  void join() { assembling_.join(); }

 private:
  static constexpr std::size_t kAssembling = 2;  // Meshes that are put together at the same time.

  asio::any_io_executor executor_;
  std::shared_ptr<UpstreamPool> upstreams_;
  RequestLimits limits_;
  Workers assembling_{kAssembling};
};

}  // namespace multitetra
