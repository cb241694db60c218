// Options and limits of message connections.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "common/net/endpoint.hpp"
#include "common/net/frame.hpp"

namespace multitetra {

struct ConnectionOptions {
  std::chrono::milliseconds handshake_timeout{10'000};  // From connecting to Welcome.
  std::chrono::milliseconds write_timeout{60'000};      // For one message to leave for the client.
  std::chrono::milliseconds linger{1'000};  // For the client to read the last message and close.
  std::uint32_t max_hello_bytes = kMaxHelloFrameBytes;  // The limit before Welcome.
  std::optional<int> send_buffer_bytes =
      // The socket's buffer; none: the system's default.
      std::nullopt;
};

struct TcpListenerOptions {
  Endpoint listen{.host = "127.0.0.1", .port = kDefaultPort};  // Port 0: the system chooses one.
  ConnectionOptions connection = {};
};

}  // namespace multitetra
