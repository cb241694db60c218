// A service behind its listeners: the datasets of this process, or those of other servers.
//
//   Server server(catalogue, {.listen = {"127.0.0.1", 7410}});
//   Server gateway(remote_service({.upstream = ...}), {.has_tcp_listener = false}, {http_listener({})});
//   server.run();  // Until stop() or drain() is called from another thread, or a signal comes.
//
// One thread, the caller of run(), does all input and output; the service has threads of its own.
// Slow clients cost memory for one step each and no thread.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/net/endpoint.hpp"
#include "server/operations/admission_control.hpp"
#include "server/operations/prometheus_metrics.hpp"
#include "server/service/dataset_catalogue.hpp"
#include "server/service/local_service.hpp"
#include "server/service/surface_service.hpp"
#include "server/session/session.hpp"
#include "server/transport/connection_options.hpp"
#include "server/transport/listener.hpp"

namespace multitetra {

struct ServerOptions {
  Endpoint listen{.host = "127.0.0.1", .port = kDefaultPort};  // Port 0: the system chooses one.
  bool has_tcp_listener = true;
  // SIGINT and SIGTERM drain, a second one stops at once; SIGHUP reloads.
  bool heed_signals = false;
  std::chrono::milliseconds drain_time{30'000};  // For requests that run when it drains.
  AdmissionOptions admission = {};
  LocalServiceOptions service = {};  // Of a server of datasets.
  SessionOptions session = {};
  // The longest time without messages or work; 0: no limit.
  std::chrono::milliseconds idle_time{0};
  ConnectionOptions connection = {};
  // On the thread of run(), when certificate and tokens were read again.
  std::function<void()> when_reloaded = {};
  // Exposed at /metrics by every listener. Null: no metrics.
  std::shared_ptr<PrometheusMetrics> metrics = {};
  bool returns_memory = false;  // Memory that is free goes back to the system now and then.
};

class Server {
 public:
  // All listeners are bound and listen: the one for TCP, if there is one, then `more`. Throws
  // AddressError that names the address when that fails, and ExitError when certificate or tokens
  // cannot be used, or what the service needs.
  Server(const MakeService& make_service, ServerOptions options,
         const std::vector<MakeListener>& more = {});
  // A server of datasets.
  Server(CataloguePtr catalogue, ServerOptions options, const std::vector<MakeListener>& more = {});
  ~Server();

  // The address of the listener for TCP, if there is one, then of the others in their order.
  [[nodiscard]] Endpoint endpoint(std::size_t listener = 0) const;
  // The addresses of all listeners, for the log.
  [[nodiscard]] std::vector<std::string> urls() const;

  // Serves until stopped. Returns when all connections are closed and all work has ended.
  void run();
  // From any thread. Clients are informed; after the linger time connections are closed.
  void stop();
  // From any thread. Nothing new is begun; stops when no request is under way any more, or the
  // drain time is over.
  void drain();
  // From any thread. Reads certificate, tokens and what the service needs again (see
  // admission_control.hpp).
  void reload();
  // From any thread, of a server of datasets. Replaces the offered datasets for new connections and
  // lists; running streams continue, and clients keep the datasets of their last list.
  void offer(CataloguePtr catalogue);

 private:
  class Running;
  std::unique_ptr<Running> running_;
};

}  // namespace multitetra
