// The service behind its doors.
//
//   Server server(catalogue, {.listen = {"127.0.0.1", 7410}});
//   server.run();  // Until stop() or drain() is called from another thread, or a signal comes.
//
// One thread, the caller of run(), does all input and output; `workers` threads make steps, and
// each step uses all processors. Slow clients cost memory for one step each and no thread.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/endpoint.hpp"
#include "server/operations/doorkeeper.hpp"
#include "server/operations/prometheus_metrics.hpp"
#include "server/service/conversation.hpp"
#include "server/service/dataset_catalogue.hpp"
#include "server/service/door.hpp"
#include "server/service/session.hpp"
#include "server/service/tcp_door.hpp"

namespace multitetra {

struct ServerOptions {
  Endpoint listen{.host = "127.0.0.1", .port = kDefaultPort};  // Port 0: the system chooses one.
  bool has_tcp_door = true;
  std::size_t workers = 2;  // Steps that are made at the same time, at least 1.
  // SIGINT and SIGTERM drain, a second one stops at once; SIGHUP reloads.
  bool heed_signals = false;
  std::chrono::milliseconds drain_time{30'000};  // For requests that run when it drains.
  DoorkeeperOptions keeper = {};
  SessionOptions session = {};
  ConversationLimits limits = {};
  ConnectionOptions connection = {};
  // Kept, and given to whoever asks at a door. The caller adds what it knows of the state.
  std::shared_ptr<PrometheusMetrics> metrics = {};
  std::function<ServiceState()> state = {};
};

class Server {
 public:
  // All doors are bound and listen. Throws AddressError that names the address when that fails, and
  // ExitError when certificate or tokens cannot be used.
  Server(CataloguePtr catalogue, ServerOptions options, const std::vector<MakeDoor>& more = {});
  ~Server();

  // The address of the door for TCP, if there is one, then of the others in their order.
  [[nodiscard]] Endpoint endpoint(std::size_t door = 0) const;
  // Of all doors, for the log.
  [[nodiscard]] std::vector<std::string> urls() const;

  // Serves until stopped. Returns when all connections are closed and all work has ended.
  void run();
  // From any thread, as in reception.hpp.
  void stop();
  void drain();
  void reload();

 private:
  class Running;
  std::unique_ptr<Running> running_;
};

}  // namespace multitetra
