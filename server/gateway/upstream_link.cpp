#include "server/gateway/upstream_link.hpp"

#include <netinet/tcp.h>

#include <cassert>
#include <utility>

#include "common/net/trust.hpp"

namespace multitetra {

using boost::system::error_code;

namespace {

tl::unexpected<Error> lost(const std::string& why) {
  return fail(ErrorCode::kUnavailable, "The connection to a server was lost: " + why + ".");
}

// What was written and is not taken by the other machine is noticed too.
void watch_writes(tcp::socket& socket, std::chrono::milliseconds limit) {
  error_code ignored;
  socket.set_option(tcp::no_delay(true), ignored);
  const auto milliseconds = static_cast<unsigned>(limit.count());
  ::setsockopt(socket.native_handle(), IPPROTO_TCP, TCP_USER_TIMEOUT, &milliseconds,
               sizeof milliseconds);
}

}  // namespace

UpstreamLink::UpstreamLink(asio::any_io_executor executor, Endpoint server, LinkOptions options)
    : server_(std::move(server)),
      options_(std::move(options)),
      socket_(executor),
      connect_timer_(executor),
      silence_timer_(executor) {
  assert(!server_.is_secure() || options_.tls);
}

asio::awaitable<Result<LinkPtr>> UpstreamLink::connect(asio::any_io_executor executor,
                                                       Endpoint server, Hello hello,
                                                       LinkOptions options) {
  const auto link = std::make_shared<UpstreamLink>(executor, std::move(server), std::move(options));
  link->connect_timer_.expires_after(link->options_.connect_timeout);
  link->connect_timer_.async_wait([link](error_code cancelled) {
    if (!cancelled) link->close();
  });
  const auto opened = co_await link->open();
  if (!opened) {
    link->close();
    co_return tl::unexpected(opened.error());
  }
  link->send(std::move(hello));
  auto welcome = co_await link->receive();
  link->connect_timer_.cancel();
  if (!welcome) co_return tl::unexpected(welcome.error());
  if (std::holds_alternative<Welcome>(*welcome)) co_return link;
  link->close();
  if (const auto* refusal = std::get_if<ErrorReply>(&*welcome)) {
    co_return tl::unexpected(refusal->error);
  }
  co_return lost("it did not say Welcome");
}

asio::awaitable<Result<void>> UpstreamLink::open() {
  const auto unreachable = [this](const std::string& why) {
    return fail(ErrorCode::kUnavailable,
                "The server " + to_string(server_) + " cannot be reached: " + why + ".");
  };
  error_code error;
  tcp::resolver resolver(socket_.get_executor());
  const auto found =
      co_await resolver.async_resolve(server_.host, std::to_string(server_.port), use_error(error));
  if (!error && !is_lost_) co_await asio::async_connect(socket_, found, use_error(error));
  if (is_lost_) co_return unreachable("it does not answer in time");
  if (error) co_return unreachable(error.message());
  watch_writes(socket_, options_.silence);
  stream_.emplace(std::move(socket_), server_.is_secure() ? options_.tls : nullptr);
  if (!server_.is_secure()) co_return Result<void>();
  expect_host(*stream_, server_.host);
  co_await stream_->async_handshake(asio::ssl::stream_base::client, use_error(error));
  if (is_lost_) co_return unreachable("it does not speak TLS in time");
  if (error) co_return unreachable(handshake_fault(*stream_, error, "--upstream-ca"));
  co_return Result<void>();
}

void UpstreamLink::send(const ClientMessage& message) {
  if (is_lost_) return;
  std::string content = serialize(message);
  to_send_.push_back(frame_header(static_cast<std::uint32_t>(content.size())) + content);
  if (std::exchange(is_writing_, true)) return;
  asio::co_spawn(
      stream_->get_executor(), [self = shared_from_this()] { return self->write(); },
      asio::detached);
}

asio::awaitable<void> UpstreamLink::write() {
  while (!to_send_.empty() && !is_lost_) {
    const std::string frame = std::move(to_send_.front());
    to_send_.pop_front();
    error_code error;
    co_await asio::async_write(*stream_, asio::buffer(frame), use_error(error));
    if (error) close();
  }
  is_writing_ = false;
}

// A Pong has done its work when it has come.
asio::awaitable<Result<ServerMessage>> UpstreamLink::receive() {
  const auto self = shared_from_this();
  for (;;) {
    auto message = co_await next_message();
    if (!message || !std::holds_alternative<Pong>(*message)) co_return message;
  }
}

asio::awaitable<Result<ServerMessage>> UpstreamLink::next_message() {
  for (;;) {
    if (is_lost_) co_return lost("it is closed");
    auto content = frames_.next();
    if (!content) {
      close();
      co_return lost(content.error().text);
    }
    if (*content) {
      auto message = parse_server_message(**content);
      if (message) co_return *std::move(message);
      close();
      co_return lost(message.error().error.text);
    }
    buffer_.resize(64 * 1024);
    await_sign();
    error_code error;
    const std::size_t size =
        co_await stream_->async_read_some(asio::buffer(buffer_), use_error(error));
    silence_timer_.cancel();
    is_sign_asked_ = false;
    if (error) {
      const bool was_silent = is_lost_;
      close();
      co_return lost(was_silent ? "it says nothing any more" : error.message());
    }
    frames_.feed({buffer_.data(), size});
  }
}

void UpstreamLink::await_sign() {
  silence_timer_.expires_after(options_.silence / 2);
  silence_timer_.async_wait([weak = weak_from_this()](error_code cancelled) {
    const auto self = weak.lock();
    if (cancelled || !self || self->is_lost_) return;
    if (std::exchange(self->is_sign_asked_, true)) {
      self->close();
      return;
    }
    self->send(Ping{});
    self->await_sign();
  });
}

void UpstreamLink::close() {
  is_lost_ = true;
  error_code ignored;
  socket_.close(ignored);
  if (stream_) stream_->close();
  connect_timer_.cancel();
  silence_timer_.cancel();
}

}  // namespace multitetra
