// The options of programs with listeners, and what follows from them: addresses,
// security, limits, and how they are operated.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/cli/command.hpp"
#include "server/http/http_options.hpp"
#include "server/routes/route_options.hpp"
#include "server/session/session.hpp"
#include "server/transport/connection_options.hpp"
#include "server/transport/server.hpp"

namespace multitetra {

// As users write it. Numbers of 0 mean no limit where that makes sense.
struct ListenerOptions {
  std::string tcp = to_string(Endpoint{.host = "127.0.0.1"});
  std::string http = "http://127.0.0.1:" + std::to_string(kDefaultHttpPort);
  std::string viewer = {};
  std::string base_path = {};

  std::string tls_certificate = {};
  std::string tls_key = {};
  std::string tokens = {};
  std::vector<std::string> allowed_origins = {};
  std::vector<std::string> allowed_hosts = {};
  std::vector<std::string> trusted_proxies = {};

  std::size_t max_connections = 1024;
  std::size_t max_connections_per_address = 256;
  double max_requests_per_second = 200;
  SessionOptions session = {};
  RequestLimits requests = {};
  std::size_t max_hello_bytes = kMaxHelloFrameBytes;
  std::size_t max_header_bytes = 16 * 1024;
  double handshake_seconds = 10;
  double write_seconds = 60;
  double idle_seconds = 600;
  RouteOptions routes = {};  // The viewer's files are read at the start.
  std::size_t min_mesh_bytes_per_second = HttpOptions{}.min_file_bytes_per_second;

  double drain_seconds = 30;
  std::string log_format = "text";
  std::string log_level = "info";
};

// The group of --help that limits stand in.
inline constexpr const char* kLimitsGroup = "Limits (0 means no limit where that makes sense)";

void add_listener_options(Command& command, ListenerOptions& options);

// An option in bytes ("512MiB"), and one in seconds.
Option* add_bytes(Command& command, const std::string& name, std::size_t& value,
                  const std::string& help);
Option* add_seconds(Command& command, const std::string& name, double& value,
                    const std::string& help);

[[nodiscard]] std::chrono::milliseconds milliseconds(double seconds);

// These throw UsageError that names the option.
//
// Empty where there shall be no such listener.
[[nodiscard]] std::optional<TcpListenerOptions> tcp_options(const ListenerOptions& options);
[[nodiscard]] std::optional<HttpOptions> http_options(const ListenerOptions& options);
// All but the service, with metrics; the admission control's observer is the request log.
[[nodiscard]] ServerOptions server_options(const ListenerOptions& options);
// The listener for HTTP, if there shall be one, with the viewer's files, which are read now.
[[nodiscard]] std::vector<MakeListener> http_listeners(const ListenerOptions& options);

// Starts the log, allows this process as many open files as the system does, and warns of what
// others could do because of the options: every client may see everything, everything can be read
// on its way, the key can be read by others on this machine. A gateway's clients may see what the
// servers behind it let them see.
void begin_serving(const ListenerOptions& options, bool is_gateway = false);
// Logs the server's addresses, serves until it is stopped, and logs that.
void serve_with_log(Server& server);

}  // namespace multitetra
