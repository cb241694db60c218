// Options and limits of message connections.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "common/net/endpoint.hpp"
#include "common/net/frame.hpp"

namespace multitetra {

struct ConnectionOptions {
  std::chrono::milliseconds handshake_timeout{10'000};  // Time from connecting to Welcome.
  std::chrono::milliseconds write_timeout{60'000};      // Time for writing one message.
  // Time for the client to read the last message and close.
  std::chrono::milliseconds linger{1'000};
  std::uint32_t max_hello_bytes = kMaxHelloFrameBytes;  // Applies before Welcome.
  // The socket's send buffer; none: the system's default.
  std::optional<int> send_buffer_bytes = std::nullopt;
};

struct TcpListenerOptions {
  Endpoint listen{.host = "127.0.0.1", .port = kDefaultPort};  // Port 0: any free port.
  ConnectionOptions connection = {};
};

}  // namespace multitetra
