#include "server/gateway/gateway_server.hpp"

#include <exception>
#include <utility>

#include "server/conversation/conversation.hpp"
#include "server/gateway/detail/remote_service.hpp"
#include "server/gateway/detail/upstream_pool.hpp"
#include "server/operations/log.hpp"
#include "server/routes/route_options.hpp"
#include "server/transport/server_runtime.hpp"
#include "server/transport/tcp_listener.hpp"

namespace multitetra {

class GatewayServer::Running {
 public:
  explicit Running(GatewayServerOptions options)
      : options_(std::move(options)), runtime_(options_.runtime) {
    options_.session.agent = "multitetra-gateway/" MULTITETRA_VERSION;
    options_.upstream.secrets = load_upstream_secrets(options_.upstream_files);
    upstreams_ = std::make_shared<UpstreamPool>(runtime_.io().get_executor(), options_.upstream);
    service_ = std::make_unique<RemoteService>(runtime_.io().get_executor(), upstreams_,
                                               options_.requests);
    std::vector<MakeListener> listeners;
    if (options_.tcp) {
      listeners.emplace_back([this](const ServerContext& server) {
        return std::make_unique<TcpListener>(server, *options_.tcp);
      });
    }
    if (options_.http) {
      listeners.emplace_back([this](const ServerContext& server) {
        return http_listener(*options_.http, options_.routes)(server);
      });
    }
    runtime_.build(*service_,
                   {.new_conversation =
                        [this](ConnectionContextPtr client) { return new_conversation(client); },
                    .state = [this] { return state(); },
                    .when_reloaded = [this] { reload_secrets(); },
                    .when_stopping = [this] { upstreams_->stop(); }},
                   listeners);
  }

  [[nodiscard]] ServerRuntime& runtime() { return runtime_; }
  [[nodiscard]] Endpoint tcp() const { return runtime_.endpoint(0); }
  [[nodiscard]] Endpoint http() const { return runtime_.endpoint(options_.tcp ? 1 : 0); }

  void run() {
    upstreams_->monitor_upstreams();
    runtime_.run();
    service_->join();
  }

 private:
  ConversationPtr new_conversation(ConnectionContextPtr client) {
    return std::make_shared<Conversation>(
        runtime_.io().get_executor(), service_->open(client),
        Session(std::make_shared<const DatasetCatalogue>(), options_.session,
                runtime_.admission().access(), {}, options_.requests),
        std::move(client), options_.idle_time);
  }

  ServiceState state() {
    const TileCache::Counts counts = upstreams_->tiles().counts();
    return {.cache_hits = counts.hits,
            .cache_misses = counts.misses,
            .cached_tiles = counts.tiles,
            .cache_bytes = counts.bytes,
            .datasets = upstreams_->datasets(),
            .upstreams = upstreams_->upstreams()};
  }

  void reload_secrets() {
    try {
      upstreams_->use(load_upstream_secrets(options_.upstream_files));
    } catch (const std::exception& failure) {
      log_line(LogLevel::kError,
               std::string(failure.what()) + " The previous credentials stay in use.", {});
    }
  }

  GatewayServerOptions options_;
  ServerRuntime runtime_;
  std::shared_ptr<UpstreamPool> upstreams_;
  std::unique_ptr<RemoteService> service_;  // Its threads end before what their work comes back to.
};

GatewayServer::GatewayServer(GatewayServerOptions options)
    : running_(std::make_unique<Running>(std::move(options))) {}
GatewayServer::~GatewayServer() = default;

Endpoint GatewayServer::http() const { return running_->http(); }
Endpoint GatewayServer::tcp() const { return running_->tcp(); }
std::vector<std::string> GatewayServer::urls() const { return running_->runtime().urls(); }
void GatewayServer::run() { running_->run(); }
void GatewayServer::stop() { running_->runtime().stop(); }
void GatewayServer::drain() { running_->runtime().drain(); }
void GatewayServer::reload() { running_->runtime().reload(); }

}  // namespace multitetra
