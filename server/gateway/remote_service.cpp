#include "server/gateway/remote_service.hpp"

#include <exception>
#include <memory>
#include <string>
#include <utility>

#include "server/gateway/detail/remote_service_client.hpp"
#include "server/gateway/detail/upstream_pool.hpp"
#include "server/operations/log.hpp"
#include "server/service/workers.hpp"

namespace multitetra {
namespace {

UpstreamOptions with_secrets(const RemoteServiceOptions& options) {
  UpstreamOptions upstream = options.upstream;
  upstream.secrets = load_upstream_secrets(options.files);
  return upstream;
}

class RemoteService : public SurfaceService {
 public:
  RemoteService(asio::any_io_executor executor, RemoteServiceOptions options)
      : executor_(executor),
        options_(std::move(options)),
        upstreams_(std::make_shared<UpstreamPool>(executor, with_secrets(options_))) {}

  void start() override { upstreams_->monitor_upstreams(); }
  bool reload() override {
    try {
      upstreams_->use(load_upstream_secrets(options_.files));
      return true;
    } catch (const std::exception& failure) {
      log_line(LogLevel::kError,
               std::string(failure.what()) + " The previous credentials stay in use.", {});
      return false;
    }
  }
  void stop() override { upstreams_->stop(); }
  void join() override { assembling_.join(); }
  ServiceState state() const override {
    ServiceState state = state_of(upstreams_->tiles());
    state.datasets = upstreams_->datasets();
    state.upstreams = upstreams_->upstreams();
    return state;
  }

  ServiceClientPtr open(ConnectionContextPtr client) override {
    return std::make_shared<RemoteServiceClient>(executor_, upstreams_, assembling_,
                                                 std::move(client), options_.requests);
  }
  std::optional<TileCache::Found> find_tile(const ContentDigest& digest,
                                            const TileCache::MaySee& may_see) override {
    return upstreams_->tiles().find_by_digest(digest, may_see);
  }
  bool is_ready() const override { return upstreams_->is_ready(); }

 private:
  static constexpr std::size_t kMaxConcurrentMeshes = 2;  // Meshes assembled at the same time.

  asio::any_io_executor executor_;
  RemoteServiceOptions options_;
  std::shared_ptr<UpstreamPool> upstreams_;
  Workers assembling_{kMaxConcurrentMeshes};
};

}  // namespace

MakeService remote_service(RemoteServiceOptions options) {
  return [options = std::move(options)](asio::any_io_executor executor) {
    return std::make_unique<RemoteService>(std::move(executor), options);
  };
}

}  // namespace multitetra
