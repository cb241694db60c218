// What a door for HTTP allows its clients.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/endpoint.hpp"
#include "common/frame.hpp"
#include "server/service/door.hpp"

namespace multitetra {

inline constexpr std::uint16_t kDefaultHttpPort = 7480;

struct HttpOptions {
  Endpoint listen{.host = "127.0.0.1", .port = kDefaultHttpPort};  // Port 0: a free one.
  std::size_t max_connections = 4096;
  TlsContexts tls = {};
  // Each for itself: TLS, a request's header from its first byte on, a WebSocket's first Hello.
  std::chrono::milliseconds handshake_timeout{10'000};
  std::chrono::milliseconds keep_alive_timeout{60'000};  // Between two requests.
  std::chrono::milliseconds idle_timeout{120'000};  // A WebSocket that answers no ping for so long.
  std::chrono::milliseconds write_timeout{60'000};  // For one message, or 256 KiB of an answer.
  std::chrono::milliseconds linger{1'000};     // For the client to read our last words and hang up.
  std::uint32_t max_header_bytes = 16 * 1024;  // Request line and header.
  std::uint32_t max_message_bytes = kMaxClientFrameBytes;  // Of a WebSocket, after Hello.
  std::optional<int> send_buffer_bytes = std::nullopt;     // None leaves it to the system.
  // "https://example.org": pages from there may read answers and open WebSockets, besides those
  // of this door itself. "*" allows all.
  std::vector<std::string> allowed_origins = {};
};

}  // namespace multitetra
