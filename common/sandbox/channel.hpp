// Messages between a program and its sandboxed process: kind, length and bytes, over a socket.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace multitetra {

struct SandboxMessage {
  char kind = 0;
  std::string bytes;
};

// One end of a pair of connected sockets.
class SandboxChannel {
 public:
  explicit SandboxChannel(int descriptor) : descriptor_(descriptor) {}
  ~SandboxChannel();
  SandboxChannel(const SandboxChannel&) = delete;
  SandboxChannel& operator=(const SandboxChannel&) = delete;

  // Returns false if the other end is closed.
  bool send(char kind, std::string_view bytes);
  // Returns false if the other end is closed, does not send the whole message in time (within
  // `timeout` for its head and again for its content, plus a second a megabyte), or announces one
  // of more than `max_bytes` bytes.
  bool receive(SandboxMessage& message, std::chrono::milliseconds timeout,
               std::uint64_t max_bytes = std::uint64_t{1} << 24);
  // Receives the bytes of a message of this kind and exactly this length without a copy. Returns
  // false after a message of another kind or length, which is stored in `other`, and if no message
  // arrives (other.kind is then 0).
  bool receive_into(char kind, std::span<std::byte> into, SandboxMessage& other,
                    std::chrono::milliseconds timeout);

 private:
  bool read(std::span<std::byte> into, std::chrono::milliseconds timeout) const;

  int descriptor_;
};

}  // namespace multitetra
