// The service behind its doors.
//
//   Server server(catalogue, {.listen = {"127.0.0.1", 7410}});
//   server.run();  // Until stop() is called from another thread, or SIGINT or SIGTERM comes.
//
// One thread, the caller of run(), does all input and output; `workers` threads make steps, and
// each step uses all processors. Slow clients cost memory for one step each and no thread.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "common/endpoint.hpp"
#include "server/service/dataset_catalogue.hpp"
#include "server/service/door.hpp"
#include "server/service/session.hpp"
#include "server/service/tcp_door.hpp"

namespace multitetra {

struct ServerOptions {
  Endpoint listen{.host = "127.0.0.1", .port = kDefaultPort};  // Port 0: the system chooses one.
  std::size_t max_connections = 256;                           // Over TCP.
  std::size_t workers = 2;       // Steps that are made at the same time, at least 1.
  bool stop_on_signals = false;  // SIGINT and SIGTERM call stop().
  TlsContexts tls = {};          // For connections over TCP.
  SessionOptions session = {};
  ConnectionOptions connection = {};
};

class Server {
 public:
  // All doors are bound and listen. Throws std::runtime_error that names the address when that
  // fails.
  Server(CataloguePtr catalogue, ServerOptions options, const std::vector<MakeDoor>& more = {});
  ~Server();

  // The address of the door for TCP, then of the others in their order.
  [[nodiscard]] Endpoint endpoint(std::size_t door = 0) const;

  // Serves until stopped. Returns when all connections are closed and all work has ended.
  void run();
  // From any thread. Clients are told; after the linger time connections are closed.
  void stop();

 private:
  class Running;
  std::unique_ptr<Running> running_;
};

}  // namespace multitetra
