// The service on a TCP port.
//
//   Server server(catalogue, {.listen = {"127.0.0.1", 7410}});
//   server.run();  // Until stop() is called from another thread, or SIGINT or SIGTERM comes.
//
// One thread, the caller of run(), does all input and output; `workers` threads make steps, and
// each step uses all processors. Slow clients cost memory for one step each and no thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "common/endpoint.hpp"
#include "server/service/connection.hpp"
#include "server/service/dataset_catalogue.hpp"

namespace multitetra {

struct ServerOptions {
  Endpoint listen{.host = "127.0.0.1", .port = kDefaultPort};  // Port 0: the system chooses one.
  std::size_t max_connections = 256;
  std::size_t workers = 2;       // Steps that are made at the same time, at least 1.
  bool stop_on_signals = false;  // SIGINT and SIGTERM call stop().
  SessionOptions session = {};
  ConnectionOptions connection = {};
};

class Server {
 public:
  // Binds and listens. Throws std::runtime_error that names the address when that fails.
  Server(CataloguePtr catalogue, ServerOptions options);
  ~Server();

  // The address it listens on, with the real port.
  [[nodiscard]] Endpoint endpoint() const;

  // Serves until stopped. Returns when all connections are closed and all work has ended.
  void run();
  // From any thread. Clients are told; after the linger time connections are closed.
  void stop();

 private:
  class Listener;
  std::unique_ptr<Listener> listener_;
};

}  // namespace multitetra
