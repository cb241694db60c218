// Messages over a byte stream: frames, or the binary messages of a WebSocket, for clients and
// servers. websocket_transport.hpp opens WebSockets.
//
//   const auto transport = frames_over(stream, {});
//   const Result<std::string> content = co_await transport->receive();
//   const auto sent = co_await transport->send(serialize(message));
//
// At most one receive and one send may be in progress. No operation has a timeout: close the stream
// to abort. The error is kUnavailable if the connection is lost, with the reason as the end of a
// sentence, and kMalformedFrame, kMessageTooLarge or kMalformedMessage if the received bytes are
// invalid; only drain() may be called after that.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "common/base/result.hpp"
#include "common/net/byte_stream.hpp"
#include "common/net/channel_options.hpp"

namespace multitetra {

class MessageTransport {
 public:
  using Clock = std::chrono::steady_clock;

  virtual ~MessageTransport() = default;

  // Returns the content of the next message.
  [[nodiscard]] virtual asio::awaitable<Result<std::string>> receive() = 0;
  // Returns the number of bytes sent.
  [[nodiscard]] virtual asio::awaitable<Result<std::size_t>> send(std::string content) = 0;
  // Reads and discards further bytes until the other side closes: closing with unread bytes would
  // reset the connection and lose our last messages.
  [[nodiscard]] virtual asio::awaitable<void> drain() = 0;
  // Announces the end of our messages, and waits for the other side's announcement if there is one.
  [[nodiscard]] virtual asio::awaitable<void> close_gracefully() = 0;
  // Takes effect with the next message.
  virtual void set_limit(std::uint32_t max_message_bytes) = 0;
  // Returns whether the connection was lost before the other side ended it.
  [[nodiscard]] virtual bool was_cut_off() const = 0;

  // Returns when bytes were last received or a message was last sent.
  [[nodiscard]] Clock::time_point last_activity() const { return last_activity_; }
  [[nodiscard]] std::uint64_t bytes_received() const { return bytes_received_; }

 protected:
  void note_activity(std::size_t bytes_that_came) {
    last_activity_ = Clock::now();
    bytes_received_ += bytes_that_came;
  }

 private:
  Clock::time_point last_activity_ = Clock::now();
  std::uint64_t bytes_received_ = 0;
};

// Frames as in frame.hpp. The stream must outlive the transport.
[[nodiscard]] std::unique_ptr<MessageTransport> frames_over(ByteStream& stream,
                                                            const TransportOptions& options);

// Returns the error of receive() and send() for a lost connection.
[[nodiscard]] inline tl::unexpected<Error> connection_error(const error_code& why) {
  return fail(ErrorCode::kUnavailable, why.message());
}

}  // namespace multitetra
