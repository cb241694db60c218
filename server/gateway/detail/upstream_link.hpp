// One connection to a server, as its client: Hello and Welcome, pings, messages in the order in
// which they are sent. Runs on the caller's executor.
//
// A server that is silent while a reply is expected is pinged, and counts as lost without a reply:
// its machine has vanished, or the process hangs.
#pragma once

#include <chrono>
#include <deque>
#include <memory>
#include <string>

#include "common/net/message_channel.hpp"
#include "common/wire/messages.hpp"

namespace multitetra {

struct LinkOptions {
  TlsContextPtr tls = nullptr;                       // Needed for tls://.
  std::chrono::milliseconds connect_timeout{3'000};  // Until Welcome.
  // The longest wait for a reply.
  std::chrono::milliseconds silence{10'000};
};

class UpstreamLink : public std::enable_shared_from_this<UpstreamLink> {
 public:
  // Connects and exchanges Hello and Welcome. kUnavailable without a reply in time, or when the
  // certificate is refused; the server's own error when it sends one instead of Welcome. Requires
  // options.tls for a secure address.
  [[nodiscard]] static asio::awaitable<Result<std::shared_ptr<UpstreamLink>>> connect(
      asio::any_io_executor executor, Endpoint server, Hello hello, LinkOptions options);

  // Whether the server answers a Ping, on a connection of its own and without a token. kUnavailable
  // without a reply in time.
  [[nodiscard]] static asio::awaitable<Result<void>> ping(asio::any_io_executor executor,
                                                          Endpoint server, LinkOptions options);

  UpstreamLink(asio::any_io_executor executor, Endpoint server, const LinkOptions& options);

  // In the order of the calls; what cannot be sent shows in receive().
  void send(const ClientMessage& message);
  // The next message, from one coroutine at a time. kUnavailable, and from then on, when the server
  // is gone.
  [[nodiscard]] asio::awaitable<Result<ServerMessage>> receive();
  void close();
  [[nodiscard]] bool is_lost() const { return !channel_.is_open(); }
  // Whether Hello offered sample shells and the server may send them to the bearer of its token.
  [[nodiscard]] bool sends_shells() const { return sends_shells_; }

 private:
  // Closes the link after the connect timeout unless connect_timer_ is canceled.
  void limit_connecting();
  asio::awaitable<Result<void>> open();
  // The next message, also a Pong.
  [[nodiscard]] asio::awaitable<Result<ServerMessage>> receive_any();
  asio::awaitable<void> write();
  void await_sign();

  asio::any_io_executor executor_;
  std::chrono::milliseconds silence_;
  std::chrono::milliseconds connect_timeout_;
  MessageChannel channel_;
  asio::steady_timer connect_timer_;
  asio::steady_timer silence_timer_;  // Runs while something is received.
  bool is_ping_pending_ = false;
  bool is_silent_ = false;  // For too long: that is why it is closed.
  std::deque<std::string> to_send_;
  bool is_writing_ = false;
  bool sends_shells_ = false;
};

using LinkPtr = std::shared_ptr<UpstreamLink>;

}  // namespace multitetra
