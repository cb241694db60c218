#include "server/programs/serving/listener_options.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <utility>

#include "common/cli/program.hpp"
#include "server/http/host.hpp"
#include "server/http/origin.hpp"
#include "server/http/target.hpp"
#include "server/operations/heap_trimmer.hpp"
#include "server/operations/log.hpp"
#include "server/operations/request_log.hpp"

namespace multitetra {
namespace {

// Raises the process's limit of open files, including connections, to the maximum allowed by the
// system, and returns it.
std::uint64_t allow_most_open_files() {
  constexpr rlim_t kMaxOpenFiles = 1 << 20;  // No server has that many connections.
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return 0;
  const rlim_t wanted = std::min(limit.rlim_max, kMaxOpenFiles);
  if (limit.rlim_cur < wanted) {
    const rlimit more = {.rlim_cur = wanted, .rlim_max = limit.rlim_max};
    if (::setrlimit(RLIMIT_NOFILE, &more) == 0) limit = more;
  }
  return limit.rlim_cur;
}

std::string machine_name() {
  std::array<char, 256> name{};
  if (::gethostname(name.data(), name.size() - 1) != 0) return "localhost";
  return name.data();
}

constexpr double kLongestSeconds = 1e7;

// Returns a finite limit; no limit becomes a hundred days.
std::chrono::milliseconds bounded(double seconds) {
  return milliseconds(seconds > 0 ? seconds : kLongestSeconds);
}

Option* add_count(Command& command, const std::string& name, std::size_t& value,
                  const std::string& help) {
  return command.add_option(name, value, help)->capture_default_str();
}

void add_addresses(Command& command, ListenerOptions& o) {
  command
      .add_option("--tcp", o.tcp,
                  "Address for TCP, or off; HOST:PORT or PORT, port 0: any free port")
      ->type_name("ADDRESS")
      ->capture_default_str();
  command.add_option("--http", o.http, "Address for HTTP, or off; also for WebSockets")
      ->type_name("ADDRESS")
      ->capture_default_str();
  command.begin_group("HTTP");
  command.add_option("--viewer", o.viewer,
                     "Folder of the web viewer's files, served at / (default: the viewer built or "
                     "installed with this program)");
  command
      .add_option("--base-path", o.base_path,
                  "Path of the HTTP listener behind a proxy, such as /volumes for "
                  "https://example.org/volumes/; the proxy may strip it or not")
      ->type_name("PATH");
}

void add_security(Command& command, ListenerOptions& o) {
  command.begin_group();
  command
      .add_option("--tls-cert", o.tls_certificate,
                  "Certificate (PEM, with its chain): listeners use TLS only. Reloaded on SIGHUP")
      ->type_name("FILE");
  command.add_option("--tls-key", o.tls_key, "The certificate's private key (PEM)")
      ->type_name("FILE");
  command
      .add_option("--tokens", o.tokens,
                  "File of tokens and the datasets of each, from `token`; without it every client "
                  "may see every dataset. Reloaded on SIGHUP")
      ->type_name("FILE");
  command
      .add_option("--allow-origin", o.allowed_origins,
                  "Origin of web pages that may use HTTP and frame the viewer; for example "
                  "https://example.org; * allows all to use it, but none to frame it (repeatable)")
      ->delimiter(',')
      ->type_name("ORIGIN");
  command
      .add_option("--allow-host", o.allowed_hosts,
                  "Host name that HTTP requests may use; for example example.org, or .example.org "
                  "for all below it; * allows all (repeatable; default: *; without TLS, tokens and "
                  "proxies only localhost and the name of this machine)")
      ->delimiter(',')
      ->type_name("HOST");
  command
      .add_option(
          "--trusted-proxy", o.trusted_proxies,
          "Address or network (10.0.0.0/8) of a trusted proxy; its X-Forwarded-For is used, and "
          "limits of one address do not apply to a multitetra-gateway (repeatable)")
      ->delimiter(',')
      ->type_name("ADDRESS");
}

void add_limits_on_clients(Command& command, ListenerOptions& o) {
  command.begin_group(kLimitsGroup);
  add_count(command, "--max-connections", o.max_connections, "Most connections");
  add_count(command, "--max-connections-per-address", o.max_connections_per_address,
            "Most connections of one address (IPv6: one /64 network)");
  command
      .add_option("--max-requests-per-second", o.max_requests_per_second,
                  "Rate limit of one token, or of one address without token; bursts of three "
                  "seconds' worth are allowed")
      ->within(0.0, 1e9)
      ->capture_default_str();
  add_count(command, "--max-queries", o.session.max_queries,
            "Most concurrent estimates, slices and probes of one connection")
      ->within(1, 64);
  add_count(command, "--max-regions", o.requests.max_regions, "Most regions of one threshold map")
      ->within(std::size_t{0}, kMaxThresholdRegions);
  command.add_flag("--surfaces-only", o.requests.surfaces_only,
                   "Serve meshes only: no sample shells, slices or probes, which contain samples");
  add_bytes(command, "--queue-bytes", o.queue_bytes, "Memory for queued requests and replies");
  add_bytes(command, "--max-message-bytes", o.session.max_message_bytes,
            "Most bytes of a client's message")
      ->within(std::size_t{1024}, std::size_t{kMaxClientFrameBytes});
  add_bytes(command, "--max-hello-bytes", o.max_hello_bytes,
            "Most bytes of a client's first message")
      ->within(std::size_t{64}, std::size_t{kMaxHelloFrameBytes});
  add_bytes(command, "--max-header-bytes", o.max_header_bytes,
            "Most bytes of the header of an HTTP request")
      ->within(std::size_t{512}, std::size_t{1} << 20);
}

void add_limits_on_time_and_meshes(Command& command, ListenerOptions& o) {
  add_seconds(command, "--handshake-seconds", o.handshake_seconds,
              "Timeout of the TLS handshake, of an HTTP header, and of the first message");
  add_seconds(command, "--write-seconds", o.write_seconds, "Timeout of sending one message");
  add_seconds(command, "--idle-seconds", o.idle_seconds,
              "Timeout of connections without messages and streams");
  command
      .add_option("--max-mesh-triangles", o.routes.max_mesh_triangles,
                  "Most triangles of a mesh in an HTTP response; making it takes about 250 bytes "
                  "of memory for each")
      ->capture_default_str();
  add_bytes(
      command, "--mesh-cache-bytes", o.routes.mesh_cache_bytes,
      "Disk space in the temporary folder for mesh files of HTTP, sent or cached; 0: no cache");
  add_bytes(command, "--min-mesh-bytes-per-second", o.min_mesh_bytes_per_second,
            "Minimum transfer rate of mesh files; slower clients are disconnected");
}

void add_operations(Command& command, ListenerOptions& o) {
  command.begin_group("Operations");
  add_seconds(command, "--drain-seconds", o.drain_seconds,
              "Timeout of running requests after SIGTERM; a second SIGTERM stops at once");
  command.add_option("--log-format", o.log_format, "Format of the log")
      ->one_of({"text", "json"})
      ->capture_default_str();
  command.add_option("--log-level", o.log_level, "Lowest severity of log lines")
      ->one_of({"debug", "info", "warning", "error", "off"})
      ->capture_default_str();
}

// Restricts host names without other protection: a web page could otherwise resolve its own name to
// this machine (DNS rebinding) and read its data.
std::vector<std::string> allowed_hosts(const ListenerOptions& o, const Endpoint& listen) {
  for (const std::string& host : o.allowed_hosts) {
    if (!is_host_pattern(host)) {
      throw UsageError("--allow-host",
                       "\"" + host +
                           "\" is not a host name; write it without scheme and port, for example "
                           "example.org, .example.org for all below it, or *.");
    }
  }
  if (!o.allowed_hosts.empty()) return o.allowed_hosts;
  const bool is_guarded =
      !o.tls_certificate.empty() || !o.tokens.empty() || !o.trusted_proxies.empty();
  if (is_guarded) return {"*"};
  if (is_this_machine(listen.host)) return {"localhost"};
  const std::string machine = machine_name();
  return {"localhost", machine, machine + ".local"};
}

ConnectionOptions connection_options(const ListenerOptions& o) {
  return {.handshake_timeout = bounded(o.handshake_seconds),
          .write_timeout = bounded(o.write_seconds),
          .max_hello_bytes = static_cast<std::uint32_t>(o.max_hello_bytes)};
}

}  // namespace

Option* add_bytes(Command& command, const std::string& name, std::size_t& value,
                  const std::string& help) {
  return command.add_option(name, value, help)->as_bytes()->capture_default_str();
}

Option* add_seconds(Command& command, const std::string& name, double& value,
                    const std::string& help) {
  return command.add_option(name, value, help)->within(0.0, kLongestSeconds)->capture_default_str();
}

void add_listener_options(Command& command, ListenerOptions& options) {
  add_addresses(command, options);
  add_security(command, options);
  add_limits_on_clients(command, options);
  add_limits_on_time_and_meshes(command, options);
  add_operations(command, options);
}

std::chrono::milliseconds milliseconds(double seconds) {
  return std::chrono::milliseconds(std::llround(seconds * 1000));
}

std::optional<TcpListenerOptions> tcp_options(const ListenerOptions& o) {
  if (o.tcp == "off") return std::nullopt;
  const Result<Endpoint> listen = parse_endpoint(o.tcp);
  if (!listen) throw UsageError("--tcp", listen.error().text);
  return TcpListenerOptions{.listen = *listen, .connection = connection_options(o)};
}

std::optional<HttpOptions> http_options(const ListenerOptions& o) {
  if (o.http == "off") return std::nullopt;
  const Result<Endpoint> listen = parse_http_endpoint(o.http);
  if (!listen) throw UsageError("--http", listen.error().text);
  const Result<std::string> base_path = parse_base_path(o.base_path);
  if (!base_path) throw UsageError("--base-path", base_path.error().text);
  HttpOptions http;
  http.listen = *listen;
  http.base_path = *base_path;
  http.connection = connection_options(o);
  http.max_header_bytes = static_cast<std::uint32_t>(o.max_header_bytes);
  for (const std::string& origin : o.allowed_origins) {
    if (!is_origin(origin)) {
      throw UsageError("--allow-origin", "\"" + origin +
                                             "\" is not an origin; write scheme, host and port, "
                                             "for example https://example.org, or *.");
    }
  }
  http.allowed_origins = o.allowed_origins;
  http.allowed_hosts = allowed_hosts(o, *listen);
  http.min_file_bytes_per_second = o.min_mesh_bytes_per_second;
  return http;
}

std::vector<MakeListener> http_listeners(const ListenerOptions& o) {
  const std::optional<HttpOptions> http = http_options(o);
  if (!http) return {};
  RouteOptions routes = o.routes;
  routes.viewer = find_viewer(o.viewer);
  return {http_listener(*http, std::move(routes))};
}

ServerOptions server_options(const ListenerOptions& o) {
  if (o.tls_certificate.empty() != o.tls_key.empty()) {
    throw UsageError("--tls-cert and --tls-key", "give both: a certificate and its key.");
  }
  if (o.tcp == "off" && o.http == "off") {
    throw UsageError("--tcp and --http", "both are off; at least one listener must be open.");
  }
  auto trusted = AddressRanges::parse(o.trusted_proxies);
  if (!trusted) throw UsageError("--trusted-proxy", trusted.error().text);
  AdmissionOptions admission = {
      .connections = {.total = o.max_connections, .per_name = o.max_connections_per_address},
      .requests = {.per_second = o.max_requests_per_second,
                   .burst = std::max(1.0, 3 * o.max_requests_per_second)},
      .queue_bytes = o.queue_bytes == 0 ? SIZE_MAX : o.queue_bytes,
      .trusted_proxies = *std::move(trusted),
      .observer = std::make_shared<RequestLog>()};
  if (!o.tls_certificate.empty()) admission.tls = {o.tls_certificate, o.tls_key};
  if (!o.tokens.empty()) admission.tokens = o.tokens;
  if (!o.token.empty()) {
    auto access = std::make_shared<AccessList>();
    access->add({.digest = digest_of_token(o.token), .rights = {}});
    admission.access = std::move(access);
  }
  const std::optional<TcpListenerOptions> tcp = tcp_options(o);
  return {.listen = tcp ? tcp->listen : Endpoint{},
          .has_tcp_listener = tcp.has_value(),
          .handles_signals = true,
          .ends_on_hangup = o.ends_on_hangup,
          .drain_time = milliseconds(o.drain_seconds),
          .admission = std::move(admission),
          .service = {.requests = o.requests},
          .session = o.session,
          .idle_time = milliseconds(o.idle_seconds),
          .connection = connection_options(o),
          .metrics = std::make_shared<PrometheusMetrics>(),
          .returns_memory = true};
}

bool is_open_to_others(const ListenerOptions& o) {
  const auto is_reachable = [](const auto& listener) {
    return listener && !is_this_machine(listener->listen.host);
  };
  return is_reachable(tcp_options(o)) || is_reachable(http_options(o));
}

namespace {

void warn_of_open_listeners(const ListenerOptions& o, const std::string& without_tokens) {
  const bool is_open = is_open_to_others(o);
  if (is_open && o.tokens.empty() && o.token.empty() && !without_tokens.empty()) {
    log_line(LogLevel::kWarning,
             "other machines can connect, and every client may see " + without_tokens +
                 ": set --tokens to restrict access",
             {});
  }
  // A proxy in front may provide TLS.
  if (is_open && o.tls_certificate.empty() && o.trusted_proxies.empty()) {
    log_line(LogLevel::kWarning,
             "other machines can connect, and their traffic is not encrypted: set --tls-cert and "
             "--tls-key, or --trusted-proxy for a proxy with TLS",
             {});
  }
  std::error_code error;
  const auto allowed = std::filesystem::status(o.tls_key, error).permissions();
  if (!o.tls_key.empty() && !error &&
      (allowed & std::filesystem::perms::others_read) != std::filesystem::perms::none) {
    log_line(LogLevel::kWarning,
             "the TLS key is readable by all users of this machine; run chmod o= on it",
             {{"file", o.tls_key}});
  }
}

void raise_open_file_limit(const ListenerOptions& o) {
  // Files besides connections: datasets, cached meshes, pollers.
  constexpr std::uint64_t kOthers = 512;
  const std::uint64_t allowed = allow_most_open_files();
  if (o.max_connections == 0 || allowed >= o.max_connections + kOthers) return;
  log_line(LogLevel::kWarning,
           "the limit of open files of this process is too low for its connections; raise it "
           "(ulimit -n) or allow fewer with --max-connections",
           {{"open_files", allowed},
            {"max_connections", static_cast<std::uint64_t>(o.max_connections)}});
}

}  // namespace

void begin_serving(const ListenerOptions& o, const std::string& without_tokens) {
  if (!o.ends_on_hangup) std::signal(SIGHUP, SIG_IGN);  // Until the server reloads on it.
  configure_allocator();
  start_log({.format = log_format_from(o.log_format).value(),
             .level = log_level_from(o.log_level).value()});
  raise_open_file_limit(o);
  warn_of_open_listeners(o, without_tokens);
}

void print_fatal_error(const std::string& program, std::string_view text) {
  if (log_format() == LogFormat::kJson && is_logged(LogLevel::kError)) {
    log_line(LogLevel::kError, text, {});
  } else {
    print_error(program, text);
  }
}

void serve_with_log(Server& server) {
  for (const std::string& url : server.urls()) log_line(LogLevel::kInfo, "listening on " + url, {});
  server.run();
  log_line(LogLevel::kInfo, "stopped", {});
}

}  // namespace multitetra
