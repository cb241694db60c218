// A service with its listeners: for the datasets of this process, or of other servers.
//
//   Server server(catalogue, {.listen = {"127.0.0.1", 7410}});
//   Server gateway(remote_service({.upstream = ...}), {.has_tcp_listener = false}, {http_listener({})});
//   server.run();  // Until stop() or drain() is called from another thread, or a signal arrives.
//
// The thread that calls run() does all input and output; the service has its own threads. A slow
// client costs memory for one step and no thread.
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
  Endpoint listen{.host = "127.0.0.1", .port = kDefaultPort};  // Port 0: any free port.
  bool has_tcp_listener = true;
  // SIGINT and SIGTERM drain, and a second one stops at once. SIGHUP reloads.
  bool handles_signals = false;
  // SIGHUP is like SIGTERM: for programs that end with their terminal.
  bool ends_on_hangup = false;
  std::chrono::milliseconds drain_time{30'000};  // For running requests when draining.
  AdmissionOptions admission = {};
  LocalServiceOptions service = {};  // For a server of datasets.
  SessionOptions session = {};
  // Connections without messages or work are closed after this time; 0: no limit.
  std::chrono::milliseconds idle_time{0};
  ConnectionOptions connection = {};
  // Called on the thread of run() after certificate and tokens were reloaded.
  std::function<void()> when_reloaded = {};
  // Exposed at /metrics by every listener. Null: no metrics.
  std::shared_ptr<PrometheusMetrics> metrics = {};
  // Periodically returns free memory to the system.
  bool returns_memory = false;
};

class Server {
 public:
  // Binds all listeners: TCP, unless disabled, then `more`. Throws AddressError, which names the
  // address, if that fails, and ExitError if certificate, tokens or files of the service cannot be
  // used.
  Server(const MakeService& make_service, ServerOptions options,
         const std::vector<MakeListener>& more = {});
  // A server of datasets.
  Server(CataloguePtr catalogue, ServerOptions options, const std::vector<MakeListener>& more = {});
  ~Server();

  // Returns the address of a listener: first TCP, unless disabled, then the others in order.
  [[nodiscard]] Endpoint endpoint(std::size_t listener = 0) const;
  // Returns the addresses of all listeners, for the log.
  [[nodiscard]] std::vector<std::string> urls() const;

  // Serves until stopped. Returns after all connections are closed and all work has ended.
  void run();
  // Notifies clients, and closes connections after the linger time. Callable from any thread.
  void stop();
  // Starts nothing new, and stops after the last request or the drain time. Callable from any
  // thread.
  void drain();
  // Reloads certificate, tokens and files of the service (see admission_control.hpp). Callable from
  // any thread.
  void reload();
  // Replaces the datasets offered to new connections and lists, for a server of datasets. Running
  // streams continue, and clients keep the datasets of their latest list. Counts a failure unless
  // all files could be read. Callable from any thread.
  void offer(CataloguePtr catalogue, bool is_complete = true);
  // Logs and counts that new datasets could not be read. Callable from any thread.
  void keep_datasets(std::string why);

 private:
  class Running;
  std::unique_ptr<Running> running_;
};

}  // namespace multitetra
