// The doors of a relay: those of a server, in front of others.
//
//   RelayServer relay({.relay = {.upstreams = {...}}, .http = {...}});
//   relay.run();  // Until stop() is called from another thread, or SIGINT or SIGTERM comes.
#pragma once

#include <memory>
#include <optional>

#include "server/gateway/http_options.hpp"
#include "server/operations/doorkeeper.hpp"
#include "server/relay/relay.hpp"
#include "server/service/session.hpp"
#include "server/service/tcp_door.hpp"

namespace multitetra {

struct RelayServerOptions {
  RelayOptions relay = {};
  std::optional<HttpOptions> http = {};  // None: no such door.
  std::optional<TcpDoorOptions> tcp = {};
  DoorkeeperOptions keeper = {};
  SessionOptions session = {.agent = "multitetra-gateway/" MULTITETRA_VERSION};
  bool stop_on_signals = false;
};

class RelayServer {
 public:
  // Binds and listens. Throws std::runtime_error that names the address when that fails.
  explicit RelayServer(RelayServerOptions options);
  ~RelayServer();

  // Requires that there is such a door.
  [[nodiscard]] Endpoint http() const;
  [[nodiscard]] Endpoint tcp() const;

  void run();
  // From any thread.
  void stop();

 private:
  class Running;
  std::unique_ptr<Running> running_;
};

}  // namespace multitetra
