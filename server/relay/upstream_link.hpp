// One conversation with a server, as its client, on the executor of who holds it.
#pragma once

#include <chrono>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "common/endpoint.hpp"
#include "common/frame.hpp"
#include "common/messages.hpp"
#include "common/net.hpp"

namespace multitetra {

class UpstreamLink : public std::enable_shared_from_this<UpstreamLink> {
 public:
  // Connected and welcomed, all within `timeout`. kUnavailable when nobody answers; what the server
  // says instead of Welcome otherwise.
  [[nodiscard]] static asio::awaitable<Result<std::shared_ptr<UpstreamLink>>> connect(
      asio::any_io_executor executor, Endpoint server, Hello hello,
      std::chrono::milliseconds timeout);

  explicit UpstreamLink(asio::any_io_executor executor);

  // In the order of the calls; what cannot be sent shows in receive().
  void send(const ClientMessage& message);
  // The next message, from one coroutine at a time. kUnavailable, and from then on, when the server
  // is gone.
  [[nodiscard]] asio::awaitable<Result<ServerMessage>> receive();
  void close();
  [[nodiscard]] bool is_lost() const { return is_lost_; }

 private:
  asio::awaitable<void> write();

  tcp::socket socket_;
  asio::steady_timer timer_;
  FrameReader frames_{kMaxServerFrameBytes};
  std::vector<char> buffer_;
  std::deque<std::string> to_send_;
  bool is_writing_ = false;
  bool is_lost_ = false;
};

using LinkPtr = std::shared_ptr<UpstreamLink>;

}  // namespace multitetra
