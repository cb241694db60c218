// A client's messages with one server, over whatever its address says: frames over TCP or TLS, or
// WebSocket messages over either. For coroutines; client/library/message_socket.hpp is the blocking
// one on top, server/gateway/upstream_link.hpp what a gateway makes of it.
//
//   MessageChannel channel(io.get_executor(), server, {.tls = tls});
//   if (const auto opened = co_await channel.open(); !opened) ...
//   co_await channel.send(serialize(Hello{}));
//   const Result<std::string> content = co_await channel.receive();
//
// At most one send and one receive are under way at a time, and everything runs on the one thread
// of the executor. No wait has a limit: a caller that times out calls close(), and
// what is under way ends with kUnavailable. The channel must outlive what is under way.
//
// Errors are whole sentences: those of message_transport.hpp; kUnavailable when the server cannot
// be reached, kInvalidArgument when it is not to be trusted. After one of them the channel is
// closed.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "common/net/channel_options.hpp"
#include "common/net/endpoint.hpp"
#include "common/net/message_transport.hpp"

namespace multitetra {

class MessageChannel {
 public:
  // Requires options.tls if the server's address is a secure one.
  MessageChannel(asio::any_io_executor executor, Endpoint server, ChannelOptions options);
  ~MessageChannel();
  MessageChannel(const MessageChannel&) = delete;
  MessageChannel& operator=(const MessageChannel&) = delete;

  // Connects, shakes hands, becomes a WebSocket: once.
  [[nodiscard]] asio::awaitable<Result<void>> open();
  [[nodiscard]] asio::awaitable<Result<void>> send(std::string content);
  [[nodiscard]] asio::awaitable<Result<std::string>> receive();
  // Bytes as they are on TCP or TLS, whatever is spoken above. Not while something is sent.
  [[nodiscard]] asio::awaitable<Result<void>> send_bytes(std::string bytes);
  // Says goodbye if the transport has a word for it, and waits for the other side's. Receiving may
  // be under way, nothing else.
  [[nodiscard]] asio::awaitable<void> leave();
  void close();

  [[nodiscard]] bool is_open() const { return is_open_; }
  [[nodiscard]] const Endpoint& server() const { return server_; }
  // When bytes came or a message was sent last.
  [[nodiscard]] std::chrono::steady_clock::time_point last_sign() const;
  [[nodiscard]] std::uint64_t bytes_received() const;

 private:
  asio::awaitable<Result<void>> connect();
  asio::awaitable<Result<void>> perform_handshake();
  tl::unexpected<Error> unreachable(const error_code& error);
  tl::unexpected<Error> not_open();
  tl::unexpected<Error> lost_in_use(Error error);
  tl::unexpected<Error> closed(Error error);

  Endpoint server_;
  ChannelOptions options_;
  tcp::socket socket_;  // Until the stream has it.
  tcp::resolver resolver_;
  std::optional<ByteStream> stream_;
  std::unique_ptr<MessageTransport> transport_;
  bool is_open_ = true;
  std::chrono::steady_clock::time_point made_ = std::chrono::steady_clock::now();
};

}  // namespace multitetra
