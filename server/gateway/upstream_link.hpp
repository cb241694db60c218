// One conversation with a server, as its client, on the executor of who holds it.
//
// A server that says nothing while it is listened to is asked for a sign of life, and lost when it
// gives none: whether its machine has vanished, or the process hangs.
#pragma once

#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/net/endpoint.hpp"
#include "common/net/frame.hpp"
#include "common/net/stream_socket.hpp"
#include "common/wire/messages.hpp"

namespace multitetra {

struct LinkOptions {
  TlsContextPtr tls = nullptr;                       // Needed for tls://.
  std::chrono::milliseconds connect_timeout{3'000};  // Until Welcome.
  std::chrono::milliseconds silence{10'000};         // Of a server that is listened to.
};

class UpstreamLink : public std::enable_shared_from_this<UpstreamLink> {
 public:
  // Connected and welcomed. kUnavailable when nobody answers in time, or is not to be trusted; what
  // the server says instead of Welcome otherwise. Requires options.tls for a secure address.
  [[nodiscard]] static asio::awaitable<Result<std::shared_ptr<UpstreamLink>>> connect(
      asio::any_io_executor executor, Endpoint server, Hello hello, LinkOptions options);

  UpstreamLink(asio::any_io_executor executor, Endpoint server, LinkOptions options);

  // In the order of the calls; what cannot be sent shows in receive().
  void send(const ClientMessage& message);
  // The next message, from one coroutine at a time. kUnavailable, and from then on, when the server
  // is gone.
  [[nodiscard]] asio::awaitable<Result<ServerMessage>> receive();
  void close();
  [[nodiscard]] bool is_lost() const { return is_lost_; }

 private:
  using Clock = std::chrono::steady_clock;

  asio::awaitable<Result<void>> open();
  asio::awaitable<Result<ServerMessage>> next_message();
  asio::awaitable<void> write();
  void await_sign();

  Endpoint server_;
  LinkOptions options_;
  tcp::socket socket_;  // Until the stream has it.
  std::optional<StreamSocket> stream_;
  asio::steady_timer connect_timer_;
  asio::steady_timer silence_timer_;  // Runs while something is received.
  bool is_sign_asked_ = false;
  FrameReader frames_{kMaxServerFrameBytes};
  std::vector<char> buffer_;
  std::deque<std::string> to_send_;
  bool is_writing_ = false;
  bool is_lost_ = false;
};

using LinkPtr = std::shared_ptr<UpstreamLink>;

}  // namespace multitetra
