// The listeners of a gateway: those of a server, in front of others.
//
//   GatewayServer gateway({.upstream = {.upstreams = {...}}, .http = {...}});
//   gateway.run();  // Until stop() or drain() is called from another thread, or a signal comes.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/gateway/upstream_options.hpp"
#include "server/http/http_options.hpp"
#include "server/routes/route_options.hpp"
#include "server/session/session.hpp"
#include "server/transport/connection_options.hpp"
#include "server/transport/server_runtime.hpp"

namespace multitetra {

struct GatewayServerOptions {
  UpstreamOptions upstream = {};
  UpstreamFiles upstream_files = {};     // The secrets of `upstream` are read from them.
  std::optional<HttpOptions> http = {};  // None: no such listener.
  RouteOptions routes = {};
  std::optional<TcpListenerOptions> tcp = {};
  ServerRuntimeOptions runtime = {};
  SessionOptions session = {};
  RequestLimits requests = {};
  std::chrono::milliseconds idle_time{0};  // As in ServerOptions.
};

class GatewayServer {
 public:
  // Binds and listens. Throws AddressError that names the address when that fails, and ExitError
  // when certificate, tokens or what servers are shown cannot be used.
  explicit GatewayServer(GatewayServerOptions options);
  ~GatewayServer();

  // Requires that there is such a listener.
  [[nodiscard]] Endpoint http() const;
  [[nodiscard]] Endpoint tcp() const;
  // The addresses of all listeners, for the log.
  [[nodiscard]] std::vector<std::string> urls() const;

  void run();
  // From any thread, as in server_runtime.hpp. A reload also reads the upstream files.
  void stop();
  void drain();
  void reload();

 private:
  class Running;
  std::unique_ptr<Running> running_;
};

}  // namespace multitetra
