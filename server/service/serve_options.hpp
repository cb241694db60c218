// What `multitetra-server serve` can be told, and what follows from it for server and doors.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "server/gateway/http_options.hpp"
#include "server/operations/log.hpp"
#include "server/service/server.hpp"

namespace multitetra {

// As users write it. Numbers of 0 mean no limit.
struct ServeOptions {
  std::vector<std::string> datasets = {};
  std::string tcp = to_string(Endpoint{.host = "127.0.0.1"});
  std::string http = "http://127.0.0.1:" + std::to_string(kDefaultHttpPort);
  std::string viewer = {};
  int threads = 0;

  std::string tls_certificate = {};
  std::string tls_key = {};
  std::string tokens = {};
  std::vector<std::string> allowed_origins = {};
  std::vector<std::string> trusted_proxies = {};

  std::size_t max_connections = 1024;
  std::size_t max_connections_per_address = 256;
  double max_requests_per_second = 200;
  std::size_t max_estimates = 4;
  std::size_t max_regions = kMaxThresholdRegions;
  double max_request_seconds = 300;
  std::size_t max_message_bytes = kMaxClientFrameBytes;
  std::size_t max_hello_bytes = kMaxHelloFrameBytes;
  std::size_t max_header_bytes = 16 * 1024;
  double handshake_seconds = 10;
  double write_seconds = 60;
  double idle_seconds = 600;
  std::size_t cache_bytes = std::size_t{512} << 20;
  std::size_t queue_bytes = std::size_t{1} << 30;
  std::uint64_t max_mesh_triangles = HttpOptions{}.max_mesh_triangles;
  std::size_t mesh_cache_bytes = HttpOptions{}.mesh_cache_bytes;

  double drain_seconds = 30;
  std::string log_format = "text";
  std::string log_level = "info";
};

void add_serve_options(CLI::App& command, ServeOptions& options);

// These throw CLI::ValidationError that names the option.
[[nodiscard]] ServerOptions server_options(const ServeOptions& options);
// Without the viewer. Empty where there shall be no such door.
[[nodiscard]] std::optional<HttpOptions> http_options(const ServeOptions& options);
[[nodiscard]] LogOptions log_options(const ServeOptions& options);

}  // namespace multitetra
