// The service of other servers: what there is for a client is what they offer together; streams and
// questions are passed on. When a server is lost in the middle of a stream, another one that has
// the same dataset is asked the same, and the client notices nothing but a pause.
//
// Memory is bounded: a few messages wait for the client, and what comes behind them waits in the
// socket of the server that sends it.
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

  [[nodiscard]] CallerPtr open(ClientContextPtr client) override;
  [[nodiscard]] std::optional<EncodedTile> find_tile(const ContentDigest& digest,
                                                     const TileCache::MaySee& may_see) override;
  [[nodiscard]] bool is_ready() const override { return upstreams_->is_ready(); }
  // Ends its threads. Nothing may be asked afterwards.
  void join() { assembling_.join(); }

 private:
  static constexpr std::size_t kAssembling = 2;  // Meshes that are put together at the same time.

  asio::any_io_executor executor_;
  std::shared_ptr<UpstreamPool> upstreams_;
  RequestLimits limits_;
  Workers assembling_{kAssembling};
};

}  // namespace multitetra
