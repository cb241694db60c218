// The doors of a relay: those of a server, in front of others.
//
//   RelayServer relay({.relay = {.upstreams = {...}}, .http = {...}});
//   relay.run();  // Until stop() or drain() is called from another thread, or a signal comes.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/gateway/http_options.hpp"
#include "server/relay/relay.hpp"
#include "server/service/reception.hpp"
#include "server/service/session.hpp"
#include "server/service/tcp_door.hpp"

namespace multitetra {

struct RelayServerOptions {
  RelayOptions relay = {};  // Its secrets come from these files:
  UpstreamFiles upstream_files = {};
  std::optional<HttpOptions> http = {};  // None: no such door.
  std::optional<TcpDoorOptions> tcp = {};
  ReceptionOptions reception = {};
  SessionOptions session = {};
  std::chrono::milliseconds idle_time{0};  // As in ConversationLimits.
};

class RelayServer {
 public:
  // Binds and listens. Throws AddressError that names the address when that fails, and ExitError
  // when certificate, tokens or what servers are shown cannot be used.
  explicit RelayServer(RelayServerOptions options);
  ~RelayServer();

  // Requires that there is such a door.
  [[nodiscard]] Endpoint http() const;
  [[nodiscard]] Endpoint tcp() const;
  // Of all doors, for the log.
  [[nodiscard]] std::vector<std::string> urls() const;

  void run();
  // From any thread, as in reception.hpp. A reload also reads what servers are shown.
  void stop();
  void drain();
  void reload();

 private:
  class Running;
  std::unique_ptr<Running> running_;
};

}  // namespace multitetra
