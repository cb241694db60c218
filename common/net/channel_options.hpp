// Limits and timeouts of a client's connection.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

#include "common/net/frame.hpp"
#include "common/net/tls_context.hpp"

namespace multitetra {

struct ChannelOptions {
  TlsContextPtr tls = nullptr;  // Needed for tls:// and wss://.
  std::uint32_t max_message_bytes = kMaxServerFrameBytes;
  std::size_t read_buffer_bytes = 64 * 1024;
  // Bytes that the other machine does not acknowledge for so long mean that it is lost; 0: the
  // system decides.
  std::chrono::milliseconds unacknowledged{0};
  std::string from = {};           // The address to connect from; empty: the system decides.
  std::string ca_option = "--ca";  // The option that names an authority.
};

}  // namespace multitetra
