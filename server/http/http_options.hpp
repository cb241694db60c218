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
  Endpoint listen{.host = "127.0.0.1", .port = kDefaultHttpPort};  // Port 0: a free one.
  // Its handshake is, each for itself: TLS, the first byte of the first request, a request's header
  // from its first byte on, a WebSocket's first Hello. A write is one message, or 256 KiB of an
  // answer.
  ConnectionOptions connection = {};
  std::chrono::milliseconds keep_alive_timeout{60'000};  // Between two requests.
  std::chrono::milliseconds idle_timeout{120'000};  // A WebSocket that answers no ping for so long.
  std::uint32_t max_header_bytes = 16 * 1024;       // Request line and header.
  // Under which a proxy shows the listener, as parse_base_path gives it; requests may have it or
  // not.
  std::string base_path = {};
  // "https://example.org": pages from there may read answers and open WebSockets, besides those
  // of this listener itself. "*" allows all.
  std::vector<std::string> allowed_origins = {};
  // The accepted host names, as in is_allowed_host; "*" allows all.
  std::vector<std::string> allowed_hosts = {"*"};
  // A client that takes a file more slowly, after write_timeout, is disconnected. 0: no limit.
  std::uint64_t min_file_bytes_per_second = 32 * 1024;
};

// "HOST:PORT", also behind "http://". kInvalidArgument, with the text and an example, otherwise.
[[nodiscard]] Result<Endpoint> parse_http_endpoint(std::string_view text);
// "http://HOST:PORT", or "https://HOST:PORT".
[[nodiscard]] std::string http_url(const Endpoint& endpoint, bool is_secure = false);

}  // namespace multitetra
