// One client connection to a server: handshake, pings, ordered messages. Runs on the caller's
// executor.
//
// If a server is silent while a reply is pending, it is pinged. Without a reply it counts as lost:
// its machine is down, or the process hangs.
#pragma once

#include <chrono>
#include <deque>
#include <memory>
#include <string>

#include "common/net/message_channel.hpp"
#include "common/wire/messages.hpp"

namespace multitetra {

struct LinkOptions {
  TlsContextPtr tls = nullptr;                       // Required for tls://.
  std::chrono::milliseconds connect_timeout{3'000};  // Time until Welcome.
  // The longest wait for any bytes.
  std::chrono::milliseconds silence_timeout{10'000};
};

class UpstreamLink : public std::enable_shared_from_this<UpstreamLink> {
 public:
  // Connects and exchanges Hello and Welcome. Returns kUnavailable after a timeout or if the
  // certificate is refused, or the error that the server sends instead of Welcome. Secure addresses
  // require options.tls.
  [[nodiscard]] static asio::awaitable<Result<std::shared_ptr<UpstreamLink>>> connect(
      asio::any_io_executor executor, Endpoint server, Hello hello, LinkOptions options);

  // Pings the server on a separate connection without a token. Returns kUnavailable after a
  // timeout.
  [[nodiscard]] static asio::awaitable<Result<Pong>> ping(asio::any_io_executor executor,
                                                          Endpoint server, LinkOptions options);

  UpstreamLink(asio::any_io_executor executor, Endpoint server, const LinkOptions& options);

  // Sends in the order of the calls. Failures are reported by receive().
  void send(const ClientMessage& message);
  // Returns the next message. Only one coroutine may call it at a time. Returns kUnavailable,
  // permanently, once the server is lost.
  [[nodiscard]] asio::awaitable<Result<ServerMessage>> receive();
  void close();
  [[nodiscard]] bool is_lost() const { return !channel_.is_open(); }
  // Returns whether Hello offered sample shells and the server may send them for its token.
  [[nodiscard]] bool sends_shells() const { return sends_shells_; }

 private:
  // Closes the link after the connect timeout unless connect_timer_ is canceled.
  void limit_connecting();
  asio::awaitable<Result<void>> open();
  // Returns the next message, including Pongs.
  [[nodiscard]] asio::awaitable<Result<ServerMessage>> receive_any();
  asio::awaitable<void> write();
  void await_sign();

  asio::any_io_executor executor_;
  std::chrono::milliseconds silence_timeout_;
  std::chrono::milliseconds connect_timeout_;
  MessageChannel channel_;
  asio::steady_timer connect_timer_;
  // Runs while receiving.
  asio::steady_timer silence_timer_;
  bool is_ping_pending_ = false;
  bool is_silent_ = false;  // Closed because of a silence timeout.
  std::deque<std::string> to_send_;
  bool is_writing_ = false;
  bool sends_shells_ = false;
};

using LinkPtr = std::shared_ptr<UpstreamLink>;

}  // namespace multitetra
