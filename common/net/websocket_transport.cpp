#include "common/net/websocket_transport.hpp"

#include <optional>
#include <utility>

#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include "common/net/stream_socket.hpp"

namespace multitetra {

namespace beast = boost::beast;
namespace http = boost::beast::http;
namespace websocket = boost::beast::websocket;

// Called by Beast, through argument-dependent lookup, after a WebSocket has been closed.
template <typename Handler>
void async_teardown(beast::role_type role, StreamSocket& stream, Handler&& handler) {
  if (stream.is_tls()) {
    stream.async_shutdown(std::forward<Handler>(handler));
  } else {
    websocket::async_teardown(role, stream.socket(), std::forward<Handler>(handler));
  }
}

// Likewise, after a timeout.
inline void beast_close_socket(StreamSocket& stream) { stream.close(); }

namespace {

const beast::string_view kSubprotocolField(kSubprotocol.data(), kSubprotocol.size());

class WebSocket final : public MessageTransport {
 public:
  WebSocket(ByteStream& stream, const TransportOptions& options)
      : socket_(stream.layer()), options_(options) {
    socket_.binary(true);
    socket_.auto_fragment(false);  // Sends each message as one frame, without copying it.
    socket_.write_buffer_bytes(16 * 1024);
    socket_.read_message_max(0);  // receive() enforces the limit.
  }

  // ---- handshakes

  asio::awaitable<Result<void>> open(Endpoint server);
  asio::awaitable<Result<void>> accept(UpgradeRequest request, WebSocketTimes times);

  // ---- messages

  asio::awaitable<Result<std::string>> receive() override {
    std::string content;
    auto buffer = asio::dynamic_buffer(content);
    do {
      error_code error;
      const std::size_t size =
          co_await socket_.async_read_some(buffer, options_.read_buffer_bytes, use_error(error));
      if (error) co_return fault(error);
      note_activity(size);
      if (content.size() > options_.max_message_bytes) co_return too_large();
    } while (!socket_.is_message_done());
    if (!socket_.got_binary()) {
      co_return fail(ErrorCode::kMalformedMessage, "Received a text message; the messages of " +
                                                       std::string(kSubprotocol) + " are binary.");
    }
    co_return content;
  }

  asio::awaitable<Result<std::size_t>> send(std::string content) override {
    error_code error;
    const std::size_t size = co_await socket_.async_write(asio::buffer(content), use_error(error));
    if (error) co_return connection_error(error);
    note_activity(0);
    co_return size;
  }

  // Reading also processes the close frame.
  asio::awaitable<void> drain() override {
    error_code error;
    while (!error && socket_.is_open()) {
      std::string dropped;
      auto buffer = asio::dynamic_buffer(dropped);
      co_await socket_.async_read_some(buffer, options_.read_buffer_bytes, use_error(error));
    }
  }

  asio::awaitable<void> close_gracefully() override {
    if (!socket_.is_open()) co_return;
    error_code ignored;
    co_await socket_.async_close(websocket::close_code::normal, use_error(ignored));
  }

  void set_limit(std::uint32_t max_message_bytes) override {
    options_.max_message_bytes = max_message_bytes;
    if (is_server_) socket_.read_message_max(max_message_bytes);
  }
  [[nodiscard]] bool was_cut_off() const override { return was_cut_off_; }

 private:
  tl::unexpected<Error> too_large() const {
    return fail(ErrorCode::kMessageTooLarge, "A message of more than " +
                                                 std::to_string(options_.max_message_bytes) +
                                                 " bytes was announced; that is the limit.");
  }
  tl::unexpected<Error> fault(const error_code& error) {
    if (error == websocket::error::message_too_big) return too_large();
    was_cut_off_ = error != websocket::error::closed;
    const bool is_protocol_fault =
        was_cut_off_ &&
        error.category() == make_error_code(websocket::error::bad_opcode).category();
    if (!is_protocol_fault) return connection_error(error);
    return fail(ErrorCode::kMalformedFrame,
                "The received bytes are not a WebSocket frame: " + error.message() + ".");
  }

  websocket::stream<StreamSocket&, /*deflateSupported=*/false> socket_;
  TransportOptions options_;
  bool is_server_ = false;
  bool was_cut_off_ = false;
};

std::string host_field(const Endpoint& server) {
  const bool is_ipv6 = server.host.find(':') != std::string::npos;
  const std::string host = is_ipv6 ? "[" + server.host + "]" : server.host;
  const std::uint16_t default_port = server.is_secure() ? 443 : 80;
  return server.port == default_port ? host : host + ":" + std::to_string(server.port);
}

Error refused_upgrade(const Endpoint& server, const websocket::response_type& response) {
  const auto status = response.result_int();
  const std::string what = to_string(server) + " replied " + std::to_string(status) + " " +
                           std::string(response.reason()) + " and did not open a WebSocket";
  const std::string& words = response.body();
  if (const auto to = response[http::field::location]; status / 100 == 3 && !to.empty()) {
    return {ErrorCode::kInvalidArgument, what + ": it redirects to " + std::string(to) +
                                             "; connect there, with ws:// or wss://."};
  }
  if (status == 503 || status == 429) {
    return {ErrorCode::kUnavailable,
            what + "; try again later" + (words.empty() ? "." : ": " + words)};
  }
  return {ErrorCode::kInvalidArgument,
          what + ": " + (words.empty() ? "check the port and the path." : words)};
}

asio::awaitable<Result<void>> WebSocket::open(Endpoint server) {
  socket_.set_option(websocket::stream_base::decorator([](websocket::request_type& request) {
    request.set(http::field::sec_websocket_protocol, kSubprotocolField);
    request.set(http::field::user_agent, "multitetra-client/" MULTITETRA_VERSION);
  }));
  websocket::response_type response;
  error_code error;
  co_await socket_.async_handshake(response, host_field(server), server.path, use_error(error));
  if (error == websocket::error::upgrade_declined) {
    co_return tl::unexpected(refused_upgrade(server, response));
  }
  const bool is_no_http = error.category() == make_error_code(http::error::bad_version).category();
  if (is_no_http && error != http::error::end_of_stream && error != http::error::partial_message) {
    co_return fail(ErrorCode::kInvalidArgument,
                   "The server at " + to_string(server) + " does not use HTTP (" + error.message() +
                       "); if this is the port for frames, write " +
                       to_string(Endpoint{
                           .host = server.host,
                           .port = server.port,
                           .transport = server.is_secure() ? Transport::kTls : Transport::kTcp}) +
                       ".");
  }
  if (error) {
    co_return fail(ErrorCode::kUnavailable,
                   "The connection to " + to_string(server) + " was lost: " + error.message() +
                       (server.is_secure() ? "." : ". If that port uses TLS, write wss://."));
  }
  if (response[http::field::sec_websocket_protocol] != kSubprotocolField) {
    co_return fail(
        ErrorCode::kUnsupportedVersion,
        to_string(server) + " does not support " + std::string(kSubprotocol) + " over WebSockets.");
  }
  note_activity(0);
  co_return Result<void>();
}

asio::awaitable<Result<void>> WebSocket::accept(UpgradeRequest request, WebSocketTimes times) {
  socket_.set_option(websocket::stream_base::timeout{
      .handshake_timeout = times.handshake, .idle_timeout = times.idle, .keep_alive_pings = true});
  socket_.set_option(websocket::stream_base::decorator([](websocket::response_type& response) {
    response.set(http::field::sec_websocket_protocol, kSubprotocolField);
    response.set(http::field::server, "multitetra/" MULTITETRA_VERSION);
  }));
  // Beast then sends clients the close code for messages that are too large.
  is_server_ = true;
  socket_.read_message_max(options_.max_message_bytes);
  error_code error;
  co_await socket_.async_accept(request, use_error(error));
  if (error) co_return connection_error(error);
  co_return Result<void>();
}

}  // namespace

asio::awaitable<Result<TransportPtr>> open_web_socket(ByteStream& stream, Endpoint server,
                                                      TransportOptions options) {
  auto socket = std::make_unique<WebSocket>(stream, options);
  const auto opened = co_await socket->open(std::move(server));
  if (!opened) co_return tl::unexpected(opened.error());
  co_return socket;
}

asio::awaitable<Result<TransportPtr>> accept_web_socket(ByteStream& stream, UpgradeRequest request,
                                                        WebSocketTimes times,
                                                        TransportOptions options) {
  auto socket = std::make_unique<WebSocket>(stream, options);
  const auto accepted = co_await socket->accept(std::move(request), times);
  if (!accepted) co_return tl::unexpected(accepted.error());
  co_return socket;
}

}  // namespace multitetra
