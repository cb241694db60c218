// The listeners of a server, their owner, and its shutdown: common to a server that makes surfaces
// and a gateway in front of others.
//
//   ServerRuntime runtime({.admission = ...});
//   runtime.build({.new_session = ...}, {make_tcp_listener, make_http_listener});
//   runtime.run();  // Until stop() or drain() is called from another thread, or a signal comes.
//
// One thread, the caller of run(), does all input and output.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/operations/admission_control.hpp"
#include "server/operations/prometheus_metrics.hpp"
#include "server/transport/listener.hpp"

namespace multitetra {

struct ServerRuntimeOptions {
  // SIGINT and SIGTERM drain, a second one stops at once; SIGHUP reloads.
  bool heed_signals = false;
  std::chrono::milliseconds drain_time{30'000};  // For requests that run when it drains.
  AdmissionOptions admission = {};
  // Exposed at /metrics by every listener. Null: no metrics.
  std::shared_ptr<PrometheusMetrics> metrics = {};
  bool returns_memory = false;  // Memory that is free goes back to the system now and then.
};

// The reactions of a server or a gateway to requests of its listeners. Called on the thread of
// run().
struct ServerHooks {
  std::function<ConversationPtr(ConnectionContextPtr client)> new_conversation;
  std::function<ServiceState()> state = {};  // For the metrics, beside what the listeners know.
  std::function<void()> when_reloaded = {};
  std::function<void()> when_stopping = {};
};

class ServerRuntime {
 public:
  // Throws ExitError when certificate or tokens cannot be used.
  explicit ServerRuntime(ServerRuntimeOptions options);
  ~ServerRuntime();

  [[nodiscard]] asio::io_context& io();
  [[nodiscard]] AdmissionControl& admission();

  // All listeners are bound and listen. Once, before run(). Throws AddressError that names the
  // address when that fails.
  void build(SurfaceService& service, ServerHooks hooks,
             const std::vector<MakeListener>& listeners);
  // The addresses of the listeners in their order.
  [[nodiscard]] Endpoint endpoint(std::size_t listener) const;
  [[nodiscard]] std::vector<std::string> urls() const;

  // Serves until stopped. Returns when all connections are closed and nothing is left to do.
  void run();
  // From any thread. Clients are informed; after the linger time connections are closed.
  void stop();
  // From any thread. Nothing new is begun; stops when no request is under way any more, or the
  // drain time is over.
  void drain();
  // From any thread. Reads certificate and tokens again (see admission_control.hpp).
  void reload();

 private:
  class Running;
  std::unique_ptr<Running> running_;
};

}  // namespace multitetra
