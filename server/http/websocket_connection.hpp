// A conversation over one WebSocket: binary messages, one coroutine reads and one writes.
#pragma once

#include <functional>
#include <memory>

#include "common/net/websocket.hpp"
#include "server/http/http_options.hpp"
#include "server/http/http_request.hpp"
#include "server/http/http_session.hpp"

namespace multitetra {

class WebSocketConnection : public HttpSession,
                            public std::enable_shared_from_this<WebSocketConnection> {
 public:
  // `upgrade` is the request that asked for it, and was found good.
  WebSocketConnection(std::unique_ptr<StreamSocket> stream, HttpRequest upgrade,
                      ClientContextPtr client, MessageSessionPtr conversation,
                      const HttpOptions& options);

  // The coroutines keep the connection alive; `on_closed` is called once when they are done.
  void start(std::function<void()> on_closed);

  void end(const Error& why) override;
  void keep_time(Clock::time_point now) override;

 private:
  asio::awaitable<void> accept_and_read();
  asio::awaitable<void> read();
  asio::awaitable<void> write();
  void spawn(asio::awaitable<void> (WebSocketConnection::*coroutine)());
  void coroutine_done(const std::exception_ptr& trouble);
  void close();

  std::unique_ptr<StreamSocket> stream_;
  WebSocket socket_;
  HttpRequest upgrade_;
  ClientContextPtr client_;
  MessageSessionPtr session_;
  const HttpOptions& options_;  // Of the listener, which outlives its connections.
  std::function<void()> on_closed_;
  int running_coroutines_ = 0;
  Deadline hello_;
  Deadline write_;
  Deadline linger_;
};

}  // namespace multitetra
