// A client's message connection to one server, over the transport its address names: frames over
// TCP or TLS, or WebSocket messages over either. Coroutine-based; client/library/message_socket.hpp
// wraps it with blocking calls, server/gateway/upstream_link.hpp uses it in gateways.
//
//   MessageChannel channel(io.get_executor(), server, {.tls = tls});
//   if (const auto opened = co_await channel.open(); !opened) ...
//   co_await channel.send(serialize(Hello{}));
//   const Result<std::string> content = co_await channel.receive();
//
// At most one send and one receive may be in progress, and everything runs on the single thread of
// the executor. No operation has a timeout: to abort, call close(), which ends pending operations
// with kUnavailable. The channel must outlive its operations.
//
// Errors are complete sentences: those of message_transport.hpp; kUnavailable if the server is
// unreachable, kInvalidArgument if it is not trusted. After an error the channel is closed.
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
  // Requires options.tls if the server's address is secure.
  MessageChannel(asio::any_io_executor executor, Endpoint server, ChannelOptions options);
  ~MessageChannel();
  MessageChannel(const MessageChannel&) = delete;
  MessageChannel& operator=(const MessageChannel&) = delete;

  // Connects and performs all handshakes. Call once.
  [[nodiscard]] asio::awaitable<Result<void>> open();
  [[nodiscard]] asio::awaitable<Result<void>> send(std::string content);
  [[nodiscard]] asio::awaitable<Result<std::string>> receive();
  // Writes raw bytes to TCP or TLS, below the message transport. Not while a send is in progress.
  [[nodiscard]] asio::awaitable<Result<void>> send_bytes(std::string bytes);
  // Closes the transport in an orderly way, if it supports that, and waits for the other side. A
  // receive may be in progress, but nothing else.
  [[nodiscard]] asio::awaitable<void> close_gracefully();
  void close();

  [[nodiscard]] bool is_open() const { return is_open_; }
  [[nodiscard]] const Endpoint& server() const { return server_; }
  // Returns when bytes were last received or a message was last sent.
  [[nodiscard]] std::chrono::steady_clock::time_point last_activity() const;
  [[nodiscard]] std::uint64_t bytes_received() const;

 private:
  asio::awaitable<Result<void>> connect();
  asio::awaitable<Result<void>> perform_handshake();
  tl::unexpected<Error> unreachable(const error_code& error);
  tl::unexpected<Error> not_open();
  tl::unexpected<Error> connection_lost(Error error);
  tl::unexpected<Error> close_with(Error error);

  Endpoint server_;
  ChannelOptions options_;
  tcp::socket socket_;  // Moved into the stream after connecting.
  tcp::resolver resolver_;
  std::optional<ByteStream> stream_;
  std::unique_ptr<MessageTransport> transport_;
  bool is_open_ = true;
  std::chrono::steady_clock::time_point made_ = std::chrono::steady_clock::now();
};

}  // namespace multitetra
