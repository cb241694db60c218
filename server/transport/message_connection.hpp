// A conversation over one connection, TCP or WebSocket: one coroutine reads messages, one writes.
#pragma once

#include <functional>
#include <memory>

#include "common/net/message_transport.hpp"
#include "server/conversation/session_runner.hpp"
#include "server/operations/admission_control.hpp"
#include "server/operations/log.hpp"
#include "server/transport/bandwidth_estimator.hpp"
#include "server/transport/connection.hpp"
#include "server/transport/connection_options.hpp"

namespace multitetra {

// Opens the message transport on an accepted stream. A failure is logged and ends the connection.
using OpenTransport = std::function<asio::awaitable<Result<std::unique_ptr<MessageTransport>>>(
    ByteStream& stream, TransportOptions options)>;

class MessageConnection : public Connection,
                          public std::enable_shared_from_this<MessageConnection> {
 public:
  MessageConnection(std::unique_ptr<ByteStream> stream, OpenTransport open,
                    ConnectionContextPtr client, SessionRunnerPtr session_runner,
                    ConnectionOptions options);

  // Both coroutines keep the connection alive. Calls `on_closed` once, when both are done.
  void start(std::function<void()> on_closed);

  [[nodiscard]] std::optional<Clock::time_point> idle_since() const override {
    return session_runner_->idle_since();
  }
  void end(const Error& why) override;
  void enforce_limits(Clock::time_point now) override;

 private:
  asio::awaitable<void> open_and_read();
  asio::awaitable<void> read();
  asio::awaitable<void> write();
  void close();
  void spawn(asio::awaitable<void> (MessageConnection::*coroutine)());
  void coroutine_done(const std::exception_ptr& failure);
  void log(LogLevel level, const std::string& text) const;

  std::unique_ptr<ByteStream> stream_;
  OpenTransport open_;
  std::unique_ptr<MessageTransport> transport_;
  ConnectionContextPtr client_;
  SessionRunnerPtr session_runner_;
  ConnectionOptions options_;
  BandwidthEstimator link_;
  std::function<void()> on_closed_;
  int running_coroutines_ = 0;
  Deadline hello_;
  Deadline write_;
  Deadline linger_;
};

}  // namespace multitetra
