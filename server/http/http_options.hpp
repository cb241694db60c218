// Options and limits of an HTTP listener.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "common/net/endpoint.hpp"
#include "server/transport/connection_options.hpp"

namespace multitetra {

inline constexpr std::uint16_t kDefaultHttpPort = 7480;

struct HttpOptions {
  Endpoint listen{.host = "127.0.0.1", .port = kDefaultHttpPort};  // Port 0: any free port.
  // `handshake_timeout` limits each of these separately: the TLS handshake, the wait for the first
  // byte of the first request, reading a request's header from its first byte, and a WebSocket's
  // Hello. `write_timeout` limits one message, or 256 KiB of an answer.
  ConnectionOptions connection = {};
  std::chrono::milliseconds keep_alive_timeout{60'000};  // Between two requests.
  std::chrono::milliseconds idle_timeout{120'000};       // For replies to WebSocket pings.
  std::uint32_t max_header_bytes = 16 * 1024;            // Request line and fields.
  // The path under which a proxy exposes the listener, as from parse_base_path; optional in
  // requests.
  std::string base_path = {};
  // Besides the listener's own pages, pages of these origins, such as "https://example.org", may
  // read answers and open WebSockets. "*" allows all.
  std::vector<std::string> allowed_origins = {};
  // The accepted host names, as for is_allowed_host; "*" allows all.
  std::vector<std::string> allowed_hosts = {"*"};
  // A client that receives a file at a lower rate is disconnected after write_timeout. 0: no limit.
  std::uint64_t min_file_bytes_per_second = 32 * 1024;
};

// Parses "HOST:PORT", with or without "http://". Returns kInvalidArgument, with the text and an
// example, otherwise.
[[nodiscard]] Result<Endpoint> parse_http_endpoint(std::string_view text);
// Returns "http://HOST:PORT" or "https://HOST:PORT".
[[nodiscard]] std::string http_url(const Endpoint& endpoint, bool is_secure = false);

}  // namespace multitetra
