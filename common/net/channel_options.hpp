// Limits and timeouts of connections.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

#include "common/net/frame.hpp"
#include "common/net/tls_context.hpp"

namespace multitetra {

struct TransportOptions {
  // The longest message that is received.
  std::uint32_t max_message_bytes = kMaxServerFrameBytes;
  std::size_t read_buffer_bytes = 64 * 1024;
};

// Options of a client.
struct ChannelOptions {
  TlsContextPtr tls = nullptr;  // Required for tls:// and wss://.
  TransportOptions transport = {};
  // Closes the connection if sent bytes stay unacknowledged for this long; 0: the system's default.
  std::chrono::milliseconds unacknowledged{0};
  std::string from = {};  // The local address to connect from; empty: chosen by the system.
  std::string ca_option = "--ca";  // The option for a certificate authority, for error texts.
};

}  // namespace multitetra
