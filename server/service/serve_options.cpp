#include "server/service/serve_options.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "server/gateway/http_door.hpp"
#include "server/service/thread_options.hpp"

namespace multitetra {
namespace {

constexpr double kLongestSeconds = 1e7;
constexpr const char* kLimits = "Limits (0 means no limit where that makes sense)";

std::chrono::milliseconds milliseconds(double seconds) {
  return std::chrono::milliseconds(std::llround(seconds * 1000));
}

// What must not be endless: where no limit is wanted it is a hundred days.
std::chrono::milliseconds bounded(double seconds) {
  return milliseconds(seconds > 0 ? seconds : kLongestSeconds);
}

CLI::Option* add_bytes(CLI::App& command, const std::string& name, std::size_t& value,
                       const std::string& help) {
  return command.add_option(name, value, help)
      ->transform(CLI::AsSizeValue(/*kb_is_1000=*/false))
      ->capture_default_str();
}

CLI::Option* add_seconds(CLI::App& command, const std::string& name, double& value,
                         const std::string& help) {
  return command.add_option(name, value, help)
      ->check(CLI::Range(0.0, kLongestSeconds))
      ->capture_default_str();
}

CLI::Option* add_count(CLI::App& command, const std::string& name, std::size_t& value,
                       const std::string& help) {
  return command.add_option(name, value, help)->capture_default_str();
}

void add_doors(CLI::App& command, ServeOptions& o) {
  command.add_option("--tcp", o.tcp, "Address and port to listen on; port 0 takes a free one")
      ->capture_default_str();
  command
      .add_option("--http", o.http, "Address and port for HTTP and WebSockets; off: no such door")
      ->capture_default_str();
  command.add_option("--viewer", o.viewer,
                     "Folder of the web viewer's files, served at / (default: the one that was "
                     "built or installed with this program)");
}

void add_security(CLI::App& command, ServeOptions& o) {
  const std::string group = "Security";
  command
      .add_option("--tls-cert", o.tls_certificate,
                  "Certificate (PEM, with those that lead to the root): all doors speak TLS only. "
                  "Read again on SIGHUP")
      ->group(group);
  command.add_option("--tls-key", o.tls_key, "The certificate's private key (PEM)")->group(group);
  command
      .add_option("--tokens", o.tokens,
                  "Who may see which datasets: a file of lines as `multitetra-server token` makes "
                  "them. Read again on SIGHUP. Without it everybody may see everything")
      ->group(group);
  command
      .add_option("--allow-origin", o.allowed_origins,
                  "Web pages of this origin, for example https://example.org, may use the HTTP "
                  "door besides its own; * allows all (repeatable)")
      ->group(group);
  command
      .add_option("--trusted-proxy", o.trusted_proxies,
                  "Address of a proxy in front, whose X-Forwarded-For is believed (repeatable)")
      ->group(group);
}

void add_limits(CLI::App& command, ServeOptions& o) {
  add_count(command, "--max-connections", o.max_connections, "In all")->group(kLimits);
  add_count(command, "--max-connections-per-address", o.max_connections_per_address,
            "From one address (IPv6: one /64 network)")
      ->group(kLimits);
  command
      .add_option("--max-requests-per-second", o.max_requests_per_second,
                  "From one address, on average; three seconds' worth in one go")
      ->check(CLI::Range(0.0, 1e9))
      ->capture_default_str()
      ->group(kLimits);
  add_count(command, "--max-estimates", o.max_estimates,
            "Under way on one connection, beside its one stream")
      ->check(CLI::Range(1, 64))
      ->group(kLimits);
  add_count(command, "--max-regions", o.max_regions, "Of one threshold map")
      ->check(CLI::Range(std::size_t{0}, kMaxThresholdRegions))
      ->group(kLimits);
  add_seconds(command, "--max-request-seconds", o.max_request_seconds,
              "Of workers' time for one request")
      ->group(kLimits);
  add_bytes(command, "--max-message-bytes", o.max_message_bytes, "A client's message")
      ->check(CLI::Range(std::size_t{1024}, std::size_t{kMaxClientFrameBytes}))
      ->group(kLimits);
  add_bytes(command, "--max-hello-bytes", o.max_hello_bytes, "A client's first message")
      ->check(CLI::Range(std::size_t{64}, std::size_t{kMaxHelloFrameBytes}))
      ->group(kLimits);
  add_bytes(command, "--max-header-bytes", o.max_header_bytes, "Of an HTTP request")
      ->check(CLI::Range(std::size_t{512}, std::size_t{1} << 20))
      ->group(kLimits);
  add_seconds(command, "--handshake-seconds", o.handshake_seconds,
              "For TLS, an HTTP header, and from connecting to Hello")
      ->group(kLimits);
  add_seconds(command, "--write-seconds", o.write_seconds, "For a client to take one message")
      ->group(kLimits);
  add_seconds(command, "--idle-seconds", o.idle_seconds,
              "Without a message from the client or a stream to it")
      ->group(kLimits);
  add_bytes(command, "--cache-bytes", o.cache_bytes,
            "Memory for encoded tiles that are kept for the next request, for example 512MiB; 0 "
            "keeps none")
      ->group(kLimits);
  add_bytes(command, "--queue-bytes", o.queue_bytes,
            "Memory for steps that wait for their clients, all together")
      ->group(kLimits);
  command
      .add_option("--max-mesh-triangles", o.max_mesh_triangles,
                  "The most triangles of a mesh in one HTTP response; while one is made it takes "
                  "about 120 bytes of memory for each")
      ->capture_default_str()
      ->group(kLimits);
  add_bytes(command, "--mesh-cache-bytes", o.mesh_cache_bytes,
            "Disk for mesh files that are kept for the next HTTP request, in the temporary folder")
      ->group(kLimits);
}

void add_operations(CLI::App& command, ServeOptions& o) {
  const std::string group = "Operations";
  add_seconds(command, "--drain-seconds", o.drain_seconds,
              "For running requests to end after SIGTERM; a second SIGTERM stops at once")
      ->group(group);
  command.add_option("--log-format", o.log_format, "text or json")
      ->check(CLI::IsMember({"text", "json"}))
      ->capture_default_str()
      ->group(group);
  command.add_option("--log-level", o.log_level, "debug, info, warning, error or off")
      ->check(CLI::IsMember({"debug", "info", "warning", "error", "off"}))
      ->capture_default_str()
      ->group(group);
}

DoorkeeperOptions keeper_options(const ServeOptions& o) {
  if (o.tls_certificate.empty() != o.tls_key.empty()) {
    throw CLI::ValidationError("--tls-cert and --tls-key",
                               "they come together: a certificate needs its key.");
  }
  DoorkeeperOptions keeper = {
      .connections = {.total = o.max_connections, .per_name = o.max_connections_per_address},
      .requests = {.per_second = o.max_requests_per_second,
                   .burst = std::max(1.0, 3 * o.max_requests_per_second)},
      .queue_bytes = o.queue_bytes == 0 ? SIZE_MAX : o.queue_bytes,
      .trusted_proxies = o.trusted_proxies};
  if (!o.tls_certificate.empty()) keeper.tls = {o.tls_certificate, o.tls_key};
  if (!o.tokens.empty()) keeper.tokens = o.tokens;
  return keeper;
}

}  // namespace

void add_serve_options(CLI::App& command, ServeOptions& options) {
  command.add_option("datasets", options.datasets, "Dataset files, or directories of them (.mtd)");
  add_doors(command, options);
  add_threads_option(command, options.threads);
  add_security(command, options);
  add_limits(command, options);
  add_operations(command, options);
}

ServerOptions server_options(const ServeOptions& o) {
  const Result<Endpoint> listen = parse_endpoint(o.tcp);
  if (!listen) throw CLI::ValidationError("--tcp", listen.error().text);
  const auto message_bytes = static_cast<std::uint32_t>(o.max_message_bytes);
  return {.listen = *listen,
          // Each step uses all threads; a second one at the same time fills what the first leaves
          // idle.
          .workers = o.threads == 1 ? std::size_t{1} : std::size_t{2},
          .heed_signals = true,
          .drain_time = milliseconds(o.drain_seconds),
          .keeper = keeper_options(o),
          .session = {.max_message_bytes = message_bytes,
                      .max_estimates = o.max_estimates,
                      .max_regions = o.max_regions},
          .limits = {.request_time = milliseconds(o.max_request_seconds),
                     .idle_time = milliseconds(o.idle_seconds)},
          .connection = {.handshake_timeout = bounded(o.handshake_seconds),
                         .write_timeout = bounded(o.write_seconds),
                         .max_message_bytes = message_bytes,
                         .max_hello_bytes = static_cast<std::uint32_t>(o.max_hello_bytes)}};
}

std::optional<HttpOptions> http_options(const ServeOptions& o) {
  if (o.http == "off") return std::nullopt;
  const Result<Endpoint> listen = parse_http_endpoint(o.http);
  if (!listen) throw CLI::ValidationError("--http", listen.error().text);
  HttpOptions http;
  http.listen = *listen;
  http.handshake_timeout = bounded(o.handshake_seconds);
  http.write_timeout = bounded(o.write_seconds);
  http.max_header_bytes = static_cast<std::uint32_t>(o.max_header_bytes);
  http.max_message_bytes = static_cast<std::uint32_t>(o.max_message_bytes);
  http.max_hello_bytes = static_cast<std::uint32_t>(o.max_hello_bytes);
  http.allowed_origins = o.allowed_origins;
  http.max_mesh_triangles = o.max_mesh_triangles;
  http.mesh_cache_bytes = o.mesh_cache_bytes;
  return http;
}

LogOptions log_options(const ServeOptions& o) {
  return {.format = log_format_from(o.log_format).value(),
          .level = log_level_from(o.log_level).value()};
}

}  // namespace multitetra
