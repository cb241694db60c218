#include "server/transport/server.hpp"

#include <utility>

#include "server/conversation/conversation.hpp"
#include "server/service/local_service.hpp"
#include "server/transport/server_runtime.hpp"
#include "server/transport/tcp_listener.hpp"

namespace multitetra {

class Server::Running {
 public:
  Running(CataloguePtr catalogue, ServerOptions options, const std::vector<MakeListener>& more)
      : options_(std::move(options)),
        runtime_({.heed_signals = options_.heed_signals,
                  .drain_time = options_.drain_time,
                  .admission = options_.admission,
                  .metrics = options_.metrics,
                  .returns_memory = options_.returns_memory}),
        service_(runtime_.io().get_executor(), std::move(catalogue), options_.service) {
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
        service_,
        {.new_conversation =
             [this](ConnectionContextPtr client) { return new_conversation(std::move(client)); },
         .state = [this] { return state(); },
         .when_reloaded = options_.when_reloaded},
        listeners);
  }
  ~Running() { service_.workers().join(); }

  [[nodiscard]] ServerRuntime& runtime() { return runtime_; }

  void offer(CataloguePtr catalogue) {
    post(runtime_.io().get_executor(),
         [this, catalogue = std::move(catalogue)] { service_.offer(catalogue); });
  }

  void run() {
    runtime_.run();
    service_.workers().join();
  }

 private:
  ConversationPtr new_conversation(ConnectionContextPtr client) {
    return std::make_shared<Conversation>(
        runtime_.io().get_executor(), service_.open(client),
        Session(
            service_.catalogue(), options_.session, runtime_.admission().access(),
            [this] { return service_.catalogue(); }, options_.service.requests),
        std::move(client), options_.idle_time);
  }

  ServiceState state() {
    ServiceState state = options_.state ? options_.state() : ServiceState{};
    state.waiting_jobs = service_.workers().waiting();
    state.datasets = service_.catalogue()->size();
    return state;
  }

  ServerOptions options_;
  ServerRuntime runtime_;
  LocalService service_;  // Its workers end before what their jobs come back to.
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
