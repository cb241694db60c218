// Messages over a byte stream: frames, or the binary messages of a WebSocket. The same for a client
// and a server; websocket_transport.hpp opens WebSockets.
//
//   const auto transport = frames_over(stream, {});
//   const Result<std::string> content = co_await transport->receive();
//   const auto sent = co_await transport->send(serialize(message));
//
// At most one receive and one send are under way at a time. No wait is limited: close the stream to
// end one. Errors are kUnavailable when the connection is lost, with the reason as the end of a
// sentence, and kMalformedFrame, kMessageTooLarge or kMalformedMessage when the received bytes are
// invalid: from then on only drain() may be called.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "common/base/result.hpp"
#include "common/net/byte_stream.hpp"
#include "common/net/frame.hpp"

namespace multitetra {

struct TransportOptions {
  std::uint32_t max_message_bytes = kMaxServerFrameBytes;
  std::size_t read_buffer_bytes = 64 * 1024;
};

class MessageTransport {
 public:
  using Clock = std::chrono::steady_clock;

  virtual ~MessageTransport() = default;

  // The content of the next message.
  [[nodiscard]] virtual asio::awaitable<Result<std::string>> receive() = 0;
  // Gives how many bytes that took.
  [[nodiscard]] virtual asio::awaitable<Result<std::size_t>> send(std::string content) = 0;
  // Reads and drops what still comes, until the other side closes: closing with unread bytes
  // would reset the connection and take our last words away from it.
  [[nodiscard]] virtual asio::awaitable<void> drain() = 0;
  // Says that nothing more comes, and waits for the same word of the other side where there is one.
  [[nodiscard]] virtual asio::awaitable<void> leave() = 0;
  // From the next message on.
  virtual void set_limit(std::uint32_t max_message_bytes) = 0;
  // Whether the connection was lost before the other side had come to an end.
  [[nodiscard]] virtual bool was_cut_off() const = 0;

  // When bytes came, or a message was sent last.
  [[nodiscard]] Clock::time_point last_sign() const { return last_sign_; }
  [[nodiscard]] std::uint64_t bytes_received() const { return bytes_received_; }

 protected:
  void note_received(std::size_t bytes_that_came) {
    last_sign_ = Clock::now();
    bytes_received_ += bytes_that_came;
  }

 private:
  Clock::time_point last_sign_ = Clock::now();
  std::uint64_t bytes_received_ = 0;
};

// As frame.hpp draws them. The stream outlives the transport.
[[nodiscard]] std::unique_ptr<MessageTransport> frames_over(ByteStream& stream,
                                                            const TransportOptions& options);

// A connection that was lost, in receive() and send().
[[nodiscard]] inline tl::unexpected<Error> lost(const error_code& why) {
  return fail(ErrorCode::kUnavailable, why.message());
}

}  // namespace multitetra
