// HTTP/1.1 on one connection: a coroutine that reads a request, answers it, and goes on.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "common/stream_socket.hpp"
#include "server/gateway/http_options.hpp"
#include "server/gateway/http_request.hpp"
#include "server/gateway/http_service.hpp"
#include "server/gateway/visitor.hpp"

namespace multitetra {

class HttpConnection : public Visitor, public std::enable_shared_from_this<HttpConnection> {
 public:
  // Service and options outlive the connection.
  HttpConnection(std::unique_ptr<StreamSocket> stream, std::string peer, HttpService& service,
                 const HttpOptions& options);

  // Takes over the stream of a connection that becomes a WebSocket.
  using Upgrade = std::function<void(std::unique_ptr<StreamSocket>, HttpRequest)>;
  // Exactly one of both is called, once, when the coroutine is done.
  void start(Upgrade on_upgrade, std::function<void()> on_closed);

  void end(const Error& why) override;
  void keep_time(Clock::time_point now) override;

 private:
  asio::awaitable<void> run();
  // The next request; nullopt when there is none, or what came cannot be followed: then that was
  // answered.
  asio::awaitable<std::optional<HttpRequest>> read_request();
  asio::awaitable<bool> write(const Answer& answer, bool with_body, bool keep_alive);
  asio::awaitable<void> hang_up();

  std::unique_ptr<StreamSocket> stream_;
  std::string peer_;
  HttpService& service_;
  const HttpOptions& options_;
  std::optional<HttpRequest> upgrade_;
  Upgrade on_upgrade_;
  std::function<void()> on_closed_;
  RequestReader requests_;
  bool is_answering_ = false;
  bool is_ending_ = false;
  Deadline deadline_;
};

}  // namespace multitetra
