#include "server/relay/upstream_link.hpp"

#include <netinet/tcp.h>

#include <utility>

namespace multitetra {

using boost::system::error_code;

namespace {

tl::unexpected<Error> lost(const std::string& why) {
  return fail(ErrorCode::kUnavailable, "The connection to a server was lost: " + why + ".");
}

// A machine that vanished without a word is noticed after about ten seconds, also when nothing is
// sent.
void watch_for_silence(tcp::socket& socket) {
  error_code ignored;
  socket.set_option(tcp::no_delay(true), ignored);
  socket.set_option(asio::socket_base::keep_alive(true), ignored);
  const auto set = [&](int option, int value) {
    ::setsockopt(socket.native_handle(), IPPROTO_TCP, option, &value, sizeof value);
  };
  set(TCP_KEEPIDLE, 4);
  set(TCP_KEEPINTVL, 2);
  set(TCP_KEEPCNT, 3);
  set(TCP_USER_TIMEOUT, 10'000);
}

}  // namespace

UpstreamLink::UpstreamLink(asio::any_io_executor executor) : socket_(executor), timer_(executor) {}

asio::awaitable<Result<LinkPtr>> UpstreamLink::connect(asio::any_io_executor executor,
                                                       Endpoint server, Hello hello,
                                                       std::chrono::milliseconds timeout) {
  const auto link = std::make_shared<UpstreamLink>(executor);
  link->timer_.expires_after(timeout);
  link->timer_.async_wait([link](error_code cancelled) {
    if (!cancelled) link->close();
  });
  error_code error;
  tcp::resolver resolver(executor);
  const auto found =
      co_await resolver.async_resolve(server.host, std::to_string(server.port), use_error(error));
  if (!error) co_await asio::async_connect(link->socket_, found, use_error(error));
  if (error || link->is_lost_) {
    link->timer_.cancel();
    co_return fail(ErrorCode::kUnavailable, "The server " + to_string(server) +
                                                " cannot be reached: " + error.message() + ".");
  }
  watch_for_silence(link->socket_);
  link->send(std::move(hello));
  auto welcome = co_await link->receive();
  link->timer_.cancel();
  if (!welcome) co_return tl::unexpected(welcome.error());
  if (const auto* refusal = std::get_if<ErrorReply>(&*welcome)) {
    co_return tl::unexpected(refusal->error);
  }
  if (!std::holds_alternative<Welcome>(*welcome)) co_return lost("it did not say Welcome");
  co_return link;
}

void UpstreamLink::send(const ClientMessage& message) {
  if (is_lost_) return;
  std::string content = serialize(message);
  to_send_.push_back(frame_header(static_cast<std::uint32_t>(content.size())) + content);
  if (std::exchange(is_writing_, true)) return;
  asio::co_spawn(
      socket_.get_executor(), [self = shared_from_this()] { return self->write(); },
      asio::detached);
}

asio::awaitable<void> UpstreamLink::write() {
  while (!to_send_.empty() && !is_lost_) {
    const std::string frame = std::move(to_send_.front());
    to_send_.pop_front();
    error_code error;
    co_await asio::async_write(socket_, asio::buffer(frame), use_error(error));
    if (error) close();
  }
  is_writing_ = false;
}

asio::awaitable<Result<ServerMessage>> UpstreamLink::receive() {
  const auto self = shared_from_this();
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
    error_code error;
    const std::size_t size =
        co_await socket_.async_read_some(asio::buffer(buffer_), use_error(error));
    if (error) {
      close();
      co_return lost(error.message());
    }
    frames_.feed({buffer_.data(), size});
  }
}

void UpstreamLink::close() {
  is_lost_ = true;
  error_code ignored;
  socket_.close(ignored);
  timer_.cancel();
}

}  // namespace multitetra
