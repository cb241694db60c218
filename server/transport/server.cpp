#include "server/transport/server.hpp"

#include <utility>

#include "server/stream/workers.hpp"
#include "server/transport/server_runtime.hpp"
#include "server/transport/stream_session.hpp"
#include "server/transport/tcp_listener.hpp"
#include "server/transport/worker_backend.hpp"

namespace multitetra {

class Server::Running {
 public:
  Running(CataloguePtr catalogue, ServerOptions options, const std::vector<MakeListener>& more)
      : catalogue_(std::move(catalogue)),
        options_(std::move(options)),
        runtime_({.heed_signals = options_.heed_signals,
                  .drain_time = options_.drain_time,
                  .admission = options_.admission,
                  .metrics = options_.metrics,
                  .returns_memory = options_.returns_memory}),
        workers_(options_.workers) {
    options_.connection.max_message_bytes = options_.session.max_message_bytes;
    std::vector<MakeListener> listeners;
    if (options_.has_tcp_listener) {
      listeners.emplace_back([this](const ServerContext& server) {
        return std::make_unique<TcpListener>(
            server,
            TcpListenerOptions{.listen = options_.listen, .connection = options_.connection});
      });
    }
    listeners.insert(listeners.end(), more.begin(), more.end());
    runtime_.build(
        {.new_session = [this](ClientContextPtr client) { return new_session(std::move(client)); },
         .state = [this] { return state(); },
         .when_reloaded = options_.when_reloaded},
        listeners);
  }
  ~Running() { workers_.join(); }

  [[nodiscard]] ServerRuntime& runtime() { return runtime_; }

  void offer(CataloguePtr catalogue) {
    post(runtime_.io().get_executor(),
         [this, catalogue = std::move(catalogue)]() mutable { catalogue_ = std::move(catalogue); });
  }

  void run() {
    runtime_.run();
    workers_.join();
  }

 private:
  StreamSessionPtr new_session(ClientContextPtr client) {
    const asio::any_io_executor executor = runtime_.io().get_executor();
    auto backend = std::make_shared<WorkerBackend>(executor, workers_, client, options_.limits);
    return std::make_shared<StreamSession>(
        executor, std::move(backend),
        Session(catalogue_, options_.session, runtime_.admission().access(),
                [this] { return catalogue_; }),
        std::move(client), options_.limits.idle_time);
  }

  ServiceState state() {
    ServiceState state = options_.state ? options_.state() : ServiceState{};
    state.waiting_jobs = workers_.waiting();
    state.datasets = catalogue_->size();
    return state;
  }

  CataloguePtr catalogue_;  // Replaced on the thread of run().
  ServerOptions options_;
  ServerRuntime runtime_;
  Workers workers_;  // They end before what their jobs come back to.
};

Server::Server(CataloguePtr catalogue, ServerOptions options, const std::vector<MakeListener>& more)
    : running_(std::make_unique<Running>(std::move(catalogue), std::move(options), more)) {}
Server::~Server() = default;

Endpoint Server::endpoint(std::size_t listener) const {
  return running_->runtime().endpoint(listener);
}
std::vector<std::string> Server::urls() const { return running_->runtime().urls(); }
void Server::run() { running_->run(); }
void Server::stop() { running_->runtime().stop(); }
void Server::drain() { running_->runtime().drain(); }
void Server::reload() { running_->runtime().reload(); }
void Server::offer(CataloguePtr catalogue) { running_->offer(std::move(catalogue)); }

}  // namespace multitetra
