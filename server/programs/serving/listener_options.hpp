// The options of programs with listeners: addresses, security, limits, operation.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/cli/command.hpp"
#include "server/http/http_options.hpp"
#include "server/routes/route_options.hpp"
#include "server/session/session.hpp"
#include "server/transport/connection_options.hpp"
#include "server/transport/server.hpp"

namespace multitetra {

// Values as given by the user. 0 means no limit where that makes sense.
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

  std::string token = {};       // No option: the only token, for all datasets.
  bool ends_on_hangup = false;  // No option: SIGHUP ends the program instead of reloading.

  std::size_t max_connections = 1024;
  std::size_t max_connections_per_address = 256;
  double max_requests_per_second = 200;
  SessionOptions session = {};
  RequestLimits requests = {};
  std::size_t max_hello_bytes = kMaxHelloFrameBytes;
  std::size_t max_header_bytes = 16 * 1024;
  std::size_t queue_bytes = std::size_t{1} << 30;
  double handshake_seconds = 10;
  double write_seconds = 60;
  double idle_seconds = 600;
  // Viewer files are read at the start.
  RouteOptions routes = {};
  std::size_t min_mesh_bytes_per_second = HttpOptions{}.min_file_bytes_per_second;

  double drain_seconds = 30;
  std::string log_format = "text";
  std::string log_level = "info";
};

// The group of limits in --help.
inline constexpr const char* kLimitsGroup = "Limits (0 means no limit where applicable)";

void add_listener_options(Command& command, ListenerOptions& options);

// Add an option in bytes ("512MiB"), and one in seconds.
Option* add_bytes(Command& command, const std::string& name, std::size_t& value,
                  const std::string& help);
Option* add_seconds(Command& command, const std::string& name, double& value,
                    const std::string& help);

[[nodiscard]] std::chrono::milliseconds milliseconds(double seconds);

// The following functions throw UsageError, which names the option.
//
// Return the options of a listener; nullopt if it is disabled.
[[nodiscard]] std::optional<TcpListenerOptions> tcp_options(const ListenerOptions& options);
[[nodiscard]] std::optional<HttpOptions> http_options(const ListenerOptions& options);
// Returns all options except the service's, with metrics; the request log observes admission
// control.
[[nodiscard]] ServerOptions server_options(const ListenerOptions& options);
// Returns the HTTP listener, unless disabled. Reads the viewer's files.
[[nodiscard]] std::vector<MakeListener> http_listeners(const ListenerOptions& options);

// Starts the log, raises the limit of open files to the system's maximum, and warns of insecure
// options: no access control, no encryption, or a key readable by other users. `without_tokens` is
// what clients may see without --tokens; empty if others decide that.
void begin_serving(const ListenerOptions& options,
                   const std::string& without_tokens = "all datasets");
// Whether other machines can connect to a listener.
[[nodiscard]] bool is_open_to_others(const ListenerOptions& options);
// Serves until stopped; logs the server's addresses at the start, and the end.
void serve_with_log(Server& server);
// Prints the error that ends a program: as a line of the log if that is JSON.
void print_fatal_error(const std::string& program, std::string_view text);

}  // namespace multitetra
