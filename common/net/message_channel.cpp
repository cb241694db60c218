#include "common/net/message_channel.hpp"

#include <array>
#include <cassert>
#include <vector>

#include "common/net/trust.hpp"
#include "common/net/websocket.hpp"

namespace multitetra {

using boost::system::error_code;

// What is spoken over the byte stream.
class MessageChannel::Wire {
 public:
  explicit Wire(MessageChannel& channel) : channel_(channel) {}
  virtual ~Wire() = default;

  virtual asio::awaitable<Result<void>> open() = 0;
  virtual asio::awaitable<Result<void>> send(std::string content) = 0;
  virtual asio::awaitable<Result<std::string>> receive() = 0;
  virtual asio::awaitable<void> leave() = 0;

 protected:
  MessageChannel& channel_;
};

// ---- frames

class MessageChannel::FrameWire final : public Wire {
 public:
  explicit FrameWire(MessageChannel& channel)
      : Wire(channel), frames_(channel.options_.max_message_bytes) {}

  asio::awaitable<Result<void>> open() override { co_return Result<void>(); }

  asio::awaitable<Result<void>> send(std::string content) override {
    const std::string header = frame_header(static_cast<std::uint32_t>(content.size()));
    const std::array<asio::const_buffer, 2> frame = {asio::buffer(header), asio::buffer(content)};
    error_code error;
    co_await asio::async_write(*channel_.stream_, frame, use_error(error));
    if (error) co_return channel_.lost(error);
    co_return Result<void>();
  }

  asio::awaitable<Result<std::string>> receive() override {
    for (;;) {
      auto content = frames_.next();
      if (!content) co_return channel_.closed(content.error());
      if (*content) co_return **std::move(content);
      buffer_.resize(channel_.options_.read_buffer_bytes);
      error_code error;
      const std::size_t size =
          co_await channel_.stream_->async_read_some(asio::buffer(buffer_), use_error(error));
      if (error) co_return channel_.lost(error);
      channel_.came(size);
      frames_.feed({buffer_.data(), size});
    }
  }

  asio::awaitable<void> leave() override { co_return; }

 private:
  FrameReader frames_;
  std::vector<char> buffer_;
};

// ---- WebSocket messages

namespace {

const beast::string_view kSubprotocolField(kSubprotocol.data(), kSubprotocol.size());

std::string host_field(const Endpoint& server) {
  const bool is_ipv6 = server.host.find(':') != std::string::npos;
  const std::string host = is_ipv6 ? "[" + server.host + "]" : server.host;
  const std::uint16_t usual = server.is_secure() ? 443 : 80;
  return server.port == usual ? host : host + ":" + std::to_string(server.port);
}

Error refused_upgrade(const Endpoint& server, const websocket::response_type& response) {
  const auto status = response.result_int();
  const std::string what = to_string(server) + " answers " + std::to_string(status) + " " +
                           std::string(response.reason()) + " and opens no WebSocket";
  if (status == 503 || status == 429) return {ErrorCode::kUnavailable, what + "; try again later."};
  return {ErrorCode::kInvalidArgument,
          what + ": " +
              (response.body().empty() ? "are the port and the path right?" : response.body())};
}

}  // namespace

class MessageChannel::WebSocketWire final : public Wire {
 public:
  explicit WebSocketWire(MessageChannel& channel) : Wire(channel), socket_(*channel.stream_) {
    socket_.binary(true);
    socket_.auto_fragment(false);
    socket_.write_buffer_bytes(16 * 1024);
    socket_.read_message_max(0);  // The limit is ours, in receive().
  }

  asio::awaitable<Result<void>> open() override {
    socket_.set_option(websocket::stream_base::decorator([](websocket::request_type& request) {
      request.set(http::field::sec_websocket_protocol, kSubprotocolField);
      request.set(http::field::user_agent, "multitetra-client/" MULTITETRA_VERSION);
    }));
    websocket::response_type response;
    error_code error;
    co_await socket_.async_handshake(response, host_field(channel_.server_), channel_.server_.path,
                                     use_error(error));
    if (error == websocket::error::upgrade_declined) {
      co_return channel_.closed(refused_upgrade(channel_.server_, response));
    }
    if (error) co_return channel_.lost(error);
    if (response[http::field::sec_websocket_protocol] != kSubprotocolField) {
      co_return channel_.closed({ErrorCode::kUnsupportedVersion,
                                 to_string(channel_.server_) + " does not speak " +
                                     std::string(kSubprotocol) + " over its WebSockets."});
    }
    co_return Result<void>();
  }

  asio::awaitable<Result<void>> send(std::string content) override {
    error_code error;
    co_await socket_.async_write(asio::buffer(content), use_error(error));
    if (error) co_return channel_.lost(error);
    co_return Result<void>();
  }

  asio::awaitable<Result<std::string>> receive() override {
    std::string content;
    auto buffer = asio::dynamic_buffer(content);
    do {
      error_code error;
      const std::size_t size = co_await socket_.async_read_some(
          buffer, channel_.options_.read_buffer_bytes, use_error(error));
      if (error) co_return fault(error);
      channel_.came(size);
      if (content.size() > channel_.options_.max_message_bytes) co_return too_large();
    } while (!socket_.is_message_done());
    if (!socket_.got_binary()) {
      co_return channel_.closed({ErrorCode::kMalformedMessage,
                                 "A text message came; the conversation is in binary ones."});
    }
    co_return content;
  }

  asio::awaitable<void> leave() override {
    error_code ignored;
    co_await socket_.async_close(websocket::close_code::normal, use_error(ignored));
  }

 private:
  tl::unexpected<Error> too_large() {
    return channel_.closed(
        {ErrorCode::kMessageTooLarge, "A message of more than " +
                                          std::to_string(channel_.options_.max_message_bytes) +
                                          " bytes comes, which is the limit here."});
  }

  tl::unexpected<Error> fault(const error_code& error) {
    const bool is_protocol_fault =
        error.category() == make_error_code(websocket::error::bad_opcode).category() &&
        error != websocket::error::closed;
    if (!is_protocol_fault) return channel_.lost(error);
    return channel_.closed(
        {ErrorCode::kMalformedFrame, "What comes is no WebSocket frame: " + error.message() + "."});
  }

  WebSocket socket_;
};

// ---- the channel

MessageChannel::MessageChannel(asio::any_io_executor executor, Endpoint server,
                               ChannelOptions options)
    : server_(std::move(server)),
      options_(std::move(options)),
      socket_(executor),
      resolver_(executor) {
  assert(!server_.is_secure() || options_.tls);
}
MessageChannel::~MessageChannel() = default;

asio::awaitable<Result<void>> MessageChannel::connect() {
  error_code error;
  const auto address = asio::ip::make_address(server_.host, error);
  if (!error) {
    co_await socket_.async_connect({address, server_.port}, use_error(error));
  } else {
    const auto found = co_await resolver_.async_resolve(server_.host, std::to_string(server_.port),
                                                        use_error(error));
    if (!error && is_open_) co_await asio::async_connect(socket_, found, use_error(error));
  }
  if (!error && !is_open_) error = asio::error::operation_aborted;
  if (error) co_return unreachable(error);
  socket_.set_option(tcp::no_delay(true), error);
  co_return Result<void>();
}

asio::awaitable<Result<void>> MessageChannel::shake_hands() {
  stream_.emplace(std::move(socket_), server_.is_secure() ? options_.tls : nullptr);
  if (!server_.is_secure()) co_return Result<void>();
  expect_host(*stream_, server_.host);
  error_code error;
  co_await stream_->async_handshake(asio::ssl::stream_base::client, use_error(error));
  if (!error) co_return Result<void>();
  // A server that is gone may come back; a certificate will not become a better one.
  const bool is_tls_fault = error.category() == asio::error::get_ssl_category();
  co_return closed({is_tls_fault ? ErrorCode::kInvalidArgument : ErrorCode::kUnavailable,
                    "No TLS with " + to_string(server_) + ": " + handshake_fault(*stream_, error)});
}

asio::awaitable<Result<void>> MessageChannel::open() {
  assert(!wire_);
  if (auto connected = co_await connect(); !connected) co_return connected;
  if (auto secured = co_await shake_hands(); !secured) co_return secured;
  if (server_.is_web_socket()) {
    wire_ = std::make_unique<WebSocketWire>(*this);
  } else {
    wire_ = std::make_unique<FrameWire>(*this);
  }
  auto opened = co_await wire_->open();
  came(0);
  co_return opened;
}

asio::awaitable<Result<void>> MessageChannel::send(std::string content) {
  if (!is_open_ || !wire_) co_return lost(asio::error::not_connected);
  auto sent = co_await wire_->send(std::move(content));
  came(0);
  co_return sent;
}

asio::awaitable<Result<std::string>> MessageChannel::receive() {
  if (!is_open_ || !wire_) co_return lost(asio::error::not_connected);
  co_return co_await wire_->receive();
}

asio::awaitable<Result<void>> MessageChannel::send_bytes(std::string bytes) {
  if (!is_open_ || !stream_) co_return lost(asio::error::not_connected);
  error_code error;
  co_await asio::async_write(*stream_, asio::buffer(bytes), use_error(error));
  if (error) co_return lost(error);
  came(0);
  co_return Result<void>();
}

asio::awaitable<void> MessageChannel::leave() {
  if (is_open_ && wire_) co_await wire_->leave();
  close();
}

void MessageChannel::close() {
  is_open_ = false;
  resolver_.cancel();
  error_code ignored;
  socket_.close(ignored);
  if (stream_) stream_->close();
}

void MessageChannel::came(std::size_t bytes) {
  last_sign_ = std::chrono::steady_clock::now();
  bytes_received_ += bytes;
}

tl::unexpected<Error> MessageChannel::closed(Error error) {
  close();
  return tl::unexpected(std::move(error));
}

tl::unexpected<Error> MessageChannel::lost(const error_code& error) {
  return closed({ErrorCode::kUnavailable, "The connection to " + to_string(server_) +
                                              " was lost: " + error.message() + "."});
}

tl::unexpected<Error> MessageChannel::unreachable(const error_code& error) {
  std::string text = "Cannot connect to " + to_string(server_) + ": " + error.message() + ".";
  if (error == asio::error::connection_refused) {
    text += " Is the server running?";
    if (!server_.is_web_socket()) {
      text += " Start it with: multitetra-server serve DATASET.mtd --tcp " +
              to_string(Endpoint{.host = server_.host, .port = server_.port});
    }
  } else if (error == asio::error::host_not_found) {
    text += " Is the host's name written correctly?";
  }
  return closed({ErrorCode::kUnavailable, std::move(text)});
}

}  // namespace multitetra
