#include "common/net/message_channel.hpp"

#include <netinet/tcp.h>

#include <cassert>
#include <utility>

#include "common/net/websocket_transport.hpp"

namespace multitetra {

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
  if (!options_.from.empty()) {
    const tcp::endpoint from(asio::ip::make_address(options_.from, error), 0);
    if (!error) socket_.open(from.protocol(), error);
    if (!error) socket_.bind(from, error);
    if (error) co_return unreachable(error);
  }
  error_code is_name;
  const auto address = asio::ip::make_address(server_.host, is_name);
  if (!is_name) {
    co_await socket_.async_connect({address, server_.port}, use_error(error));
  } else {
    const auto found = co_await resolver_.async_resolve(server_.host, std::to_string(server_.port),
                                                        use_error(error));
    // Trying several addresses would reopen the socket without the address it is bound to.
    if (!error && is_open_ && !options_.from.empty()) {
      co_await socket_.async_connect(found.begin()->endpoint(), use_error(error));
    } else if (!error && is_open_) {
      co_await asio::async_connect(socket_, found, use_error(error));
    }
  }
  if (!error && !is_open_) error = asio::error::operation_aborted;
  if (error) co_return unreachable(error);
  set_socket_options(socket_);
  if (options_.unacknowledged.count() > 0) {
    const auto milliseconds = static_cast<unsigned>(options_.unacknowledged.count());
    ::setsockopt(socket_.native_handle(), IPPROTO_TCP, TCP_USER_TIMEOUT, &milliseconds,
                 sizeof milliseconds);
  }
  co_return Result<void>();
}

asio::awaitable<Result<void>> MessageChannel::perform_handshake() {
  stream_.emplace(std::move(socket_), server_.is_secure() ? options_.tls : nullptr);
  const auto trusted = co_await stream_->handshake_as_client(server_.host, options_.ca_option);
  if (trusted) co_return Result<void>();
  co_return close_with({trusted.error().code, "Cannot establish TLS with " + to_string(server_) +
                                                  ": " + trusted.error().text});
}

asio::awaitable<Result<void>> MessageChannel::open() {
  assert(!transport_);
  if (auto connected = co_await connect(); !connected) co_return connected;
  if (auto secured = co_await perform_handshake(); !secured) co_return secured;
  if (!server_.is_web_socket()) {
    transport_ = frames_over(*stream_, options_.transport);
    co_return Result<void>();
  }
  auto opened = co_await open_web_socket(*stream_, server_, options_.transport);
  if (!opened) co_return close_with(opened.error());
  transport_ = *std::move(opened);
  co_return Result<void>();
}

asio::awaitable<Result<void>> MessageChannel::send(std::string content) {
  if (!is_open_ || !transport_) co_return not_open();
  const auto sent = co_await transport_->send(std::move(content));
  if (!sent) co_return connection_lost(sent.error());
  co_return Result<void>();
}

asio::awaitable<Result<std::string>> MessageChannel::receive() {
  if (!is_open_ || !transport_) co_return not_open();
  auto content = co_await transport_->receive();
  if (!content) co_return connection_lost(content.error());
  co_return content;
}

asio::awaitable<Result<void>> MessageChannel::send_bytes(std::string bytes) {
  if (!is_open_ || !stream_) co_return not_open();
  const Transfer sent = co_await stream_->write(asio::buffer(bytes));
  if (sent.error) co_return connection_lost(connection_error(sent.error).value());
  co_return Result<void>();
}

asio::awaitable<void> MessageChannel::close_gracefully() {
  if (is_open_ && transport_ && server_.is_web_socket()) co_await transport_->close_gracefully();
  close();
}

void MessageChannel::close() {
  is_open_ = false;
  resolver_.cancel();
  error_code ignored;
  socket_.close(ignored);
  if (stream_) stream_->close();
}

std::chrono::steady_clock::time_point MessageChannel::last_activity() const {
  return transport_ ? transport_->last_activity() : made_;
}

std::uint64_t MessageChannel::bytes_received() const {
  return transport_ ? transport_->bytes_received() : 0;
}

tl::unexpected<Error> MessageChannel::close_with(Error error) {
  close();
  return tl::unexpected(std::move(error));
}

// Completes a transport's description of a lost connection to a sentence.
tl::unexpected<Error> MessageChannel::connection_lost(Error error) {
  if (error.code == ErrorCode::kUnavailable) {
    error.text = "The connection to " + to_string(server_) + " was lost: " + error.text + ".";
    if (!server_.is_secure() && bytes_received() == 0) {
      error.text += " No reply: if that port uses TLS, write tls:// or wss://.";
    }
  }
  return close_with(std::move(error));
}

tl::unexpected<Error> MessageChannel::not_open() {
  return connection_lost(connection_error(asio::error::not_connected).value());
}

tl::unexpected<Error> MessageChannel::unreachable(const error_code& error) {
  std::string text = "Cannot connect to " + to_string(server_) + ": " + error.message() + ".";
  if (error == asio::error::connection_refused) {
    text += " Is the server running?";
    if (!server_.is_web_socket() && !server_.is_secure()) {
      text += " Start it with: multitetra-server serve DATASET.mtd --tcp " +
              to_string(Endpoint{.host = server_.host, .port = server_.port});
    }
  } else if (error == asio::error::host_not_found) {
    text += " Check the host name.";
  }
  return close_with({ErrorCode::kUnavailable, std::move(text)});
}

}  // namespace multitetra
