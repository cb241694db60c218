// A conversation over one TCP or TLS connection: one coroutine reads frames, one writes them.
#pragma once

#include <array>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>

#include "common/net/frame.hpp"
#include "common/net/stream_socket.hpp"
#include "server/operations/admission_control.hpp"
#include "server/transport/message_session.hpp"

namespace multitetra {

struct ConnectionOptions {
  std::chrono::milliseconds handshake_timeout{10'000};  // From connecting to Welcome.
  std::chrono::milliseconds write_timeout{60'000};      // For one message to leave for the client.
  std::chrono::milliseconds linger{1'000};  // For the client to read our last words and hang up.
  std::uint32_t max_message_bytes = kMaxClientFrameBytes;  // What we accept,
  std::uint32_t max_hello_bytes = kMaxHelloFrameBytes;     // and before Welcome.
  std::optional<int> send_buffer_bytes =
      std::nullopt;  // Of the socket; none leaves it to the system.
};

class Connection : public std::enable_shared_from_this<Connection> {
 public:
  // Plain TCP if `tls` is null.
  Connection(tcp::socket socket, TlsContextPtr tls, ClientContextPtr client,
             MessageSessionPtr conversation, ConnectionOptions options);

  // Both coroutines keep the connection alive; `on_closed` is called once when they are done.
  void start(std::function<void()> on_closed);
  // Says why and ends; within the linger time the socket is closed whatever the client does.
  void end(const Error& error);

 private:
  asio::awaitable<void> greet_and_read();
  asio::awaitable<void> read();
  asio::awaitable<void> write();
  asio::awaitable<void> receive_frames(FrameReader& frames);
  void close_after(asio::steady_timer& timer, std::chrono::milliseconds delay);
  void close();
  void spawn(asio::awaitable<void> (Connection::*coroutine)());
  void coroutine_done(const std::exception_ptr& trouble);

  StreamSocket stream_;
  ClientContextPtr client_;
  MessageSessionPtr session_;
  ConnectionOptions options_;
  std::function<void()> on_closed_;
  int running_coroutines_ = 0;
  asio::steady_timer handshake_timer_;
  asio::steady_timer write_timer_;
  asio::steady_timer linger_timer_;
};

}  // namespace multitetra
