// HTTP/1.1 on one connection: a coroutine reads and answers requests sequentially.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "common/net/byte_stream.hpp"
#include "server/http/http_options.hpp"
#include "server/http/http_request.hpp"
#include "server/http/request_handler.hpp"
#include "server/transport/connection.hpp"

namespace multitetra {

class HttpConnection : public Connection, public std::enable_shared_from_this<HttpConnection> {
 public:
  // Handler and options outlive the connection. If set, `refusal` is the answer to the first
  // request, unless that is a probe.
  HttpConnection(std::unique_ptr<ByteStream> stream, ConnectionContextPtr client,
                 std::optional<Error> refusal, RequestHandler& handler, const HttpOptions& options);

  // Takes over the stream when the connection becomes a WebSocket.
  using Upgrade = std::function<void(std::unique_ptr<ByteStream>, HttpRequest)>;
  // Calls exactly one of both, once, when the coroutine is done.
  void start(Upgrade on_upgrade, std::function<void()> on_closed);

  [[nodiscard]] std::optional<Clock::time_point> idle_since() const override;
  void end(const Error& why) override;
  void enforce_limits(Clock::time_point now) override;

 private:
  asio::awaitable<void> run();
  // Returns the next request; nullopt at the end of input or after it has answered a malformed
  // request.
  asio::awaitable<std::optional<HttpRequest>> read_request();
  // Returns the error for a request that is above the limits of connections.
  [[nodiscard]] Result<void> check_admission(const HttpRequest& request);
  // Returns whether everything was written.
  asio::awaitable<bool> write(const HttpResponse& response, bool with_body, bool keep_alive);
  asio::awaitable<bool> write_file(const ScratchFile& file, std::uint64_t first,
                                   std::uint64_t length);
  asio::awaitable<void> close_connection();
  asio::awaitable<void> refuse_plain_http();
  asio::awaitable<void> drain();
  // Reports an answered request to the observer. `request` is null if the bytes were malformed.
  void send(const HttpRequest* request, const RequestContext& context, const HttpResponse& response,
            bool with_body, std::string_view outcome);
  // Cancels the request if the client closes the connection meanwhile.
  void watch();
  void watch_unread();

  std::unique_ptr<ByteStream> stream_;
  ConnectionContextPtr client_;
  std::optional<Error> refusal_;
  RequestHandler& handler_;
  const HttpOptions& options_;
  std::optional<HttpRequest> upgrade_;
  Upgrade on_upgrade_;
  std::function<void()> on_closed_;
  RequestReader requests_;
  std::shared_ptr<RequestContext> context_;      // Set while answering.
  Clock::time_point idle_since_ = Clock::now();  // Valid while idle.
  asio::steady_timer watch_timer_;
  bool is_watching_ = false;
  bool is_answering_ = false;
  bool had_request_ = false;
  bool is_ending_ = false;
  Deadline deadline_;
};

}  // namespace multitetra
