#include "server/gateway/detail/upstream_link.hpp"

#include <algorithm>
#include <utility>

#include "common/net/coroutines.hpp"

namespace multitetra {
namespace {

tl::unexpected<Error> lost_link(const std::string& why) {
  return fail(ErrorCode::kUnavailable, "The connection to a server was lost: " + why + ".");
}

}  // namespace

UpstreamLink::UpstreamLink(asio::any_io_executor executor, Endpoint server,
                           const LinkOptions& options)
    : executor_(executor),
      silence_timeout_(options.silence_timeout),
      connect_timeout_(options.connect_timeout),
      channel_(executor, std::move(server),
               {.tls = options.tls,
                .unacknowledged = options.silence_timeout,
                .ca_option = "--upstream-ca"}),
      connect_timer_(executor),
      silence_timer_(executor) {}

void UpstreamLink::limit_connecting() {
  connect_timer_.expires_after(connect_timeout_);
  when_expired(connect_timer_, [link = shared_from_this()] {
    link->is_silent_ = true;
    link->close();
  });
}

asio::awaitable<Result<LinkPtr>> UpstreamLink::connect(asio::any_io_executor executor,
                                                       Endpoint server, Hello hello,
                                                       LinkOptions options) {
  const auto link = std::make_shared<UpstreamLink>(executor, std::move(server), options);
  link->limit_connecting();
  const auto opened = co_await link->open();
  if (!opened) {
    link->close();
    co_return tl::unexpected(opened.error());
  }
  link->send(std::move(hello));
  auto welcome = co_await link->receive();
  link->connect_timer_.cancel();
  if (!welcome) co_return tl::unexpected(welcome.error());
  if (const auto* granted = std::get_if<Welcome>(&*welcome)) {
    link->sends_shells_ = std::ranges::count(granted->codecs, PayloadCodec::kSampleShell) > 0;
    co_return link;
  }
  link->close();
  if (const auto* refusal = std::get_if<ErrorReply>(&*welcome)) {
    co_return tl::unexpected(refusal->error);
  }
  co_return lost_link("it sent no Welcome");
}

asio::awaitable<Result<Pong>> UpstreamLink::ping(asio::any_io_executor executor, Endpoint server,
                                                 LinkOptions options) {
  const auto link = std::make_shared<UpstreamLink>(executor, std::move(server), options);
  link->limit_connecting();
  const auto opened = co_await link->open();
  if (!opened) {
    link->close();
    co_return tl::unexpected(opened.error());
  }
  link->send(Ping{});
  const auto answer = co_await link->receive_any();
  link->close();
  if (!answer) co_return tl::unexpected(answer.error());
  const auto* const error = std::get_if<ErrorReply>(&*answer);
  if (error && error->error.code == ErrorCode::kUnavailable) co_return tl::unexpected(error->error);
  const auto* const pong = std::get_if<Pong>(&*answer);
  co_return pong ? *pong : Pong{};
}

// Connection errors are kUnavailable, as another server may serve the request.
asio::awaitable<Result<void>> UpstreamLink::open() {
  const auto opened = co_await channel_.open();
  if (opened) co_return Result<void>();
  co_return fail(ErrorCode::kUnavailable, is_silent_
                                              ? "The server " + to_string(channel_.server()) +
                                                    " cannot be reached: it did not reply in time."
                                              : opened.error().text);
}

void UpstreamLink::send(const ClientMessage& message) {
  if (is_lost()) return;
  to_send_.push_back(serialize(message));
  if (std::exchange(is_writing_, true)) return;
  spawn(executor_, [self = shared_from_this()] { return self->write(); });
}

asio::awaitable<void> UpstreamLink::write() {
  while (!to_send_.empty() && !is_lost()) {
    std::string content = std::move(to_send_.front());
    to_send_.pop_front();
    co_await channel_.send(std::move(content));
  }
  is_writing_ = false;
}

asio::awaitable<Result<ServerMessage>> UpstreamLink::receive_any() {
  const auto self = shared_from_this();
  if (is_lost()) co_return lost_link("it is closed");
  await_sign();
  const Result<std::string> content = co_await channel_.receive();
  silence_timer_.cancel();
  is_ping_pending_ = false;
  if (!content) {
    close();
    co_return lost_link(is_silent_ ? "no reply to pings" : content.error().text);
  }
  auto message = parse_server_message(*content);
  if (message) co_return *std::move(message);
  close();
  co_return lost_link(message.error().error.text);
}

// Discards Pongs, which have already reset the silence timer.
asio::awaitable<Result<ServerMessage>> UpstreamLink::receive() {
  for (;;) {
    auto message = co_await receive_any();
    if (!message || !std::holds_alternative<Pong>(*message)) co_return message;
  }
}

// Any received bytes are a sign of life, even an incomplete message.
void UpstreamLink::await_sign() {
  silence_timer_.expires_after(silence_timeout_ / 2);
  silence_timer_.async_wait(
      [weak = weak_from_this(), heard = channel_.bytes_received()](error_code cancelled) {
        const auto self = weak.lock();
        if (cancelled || !self || self->is_lost()) return;
        const bool is_heard = self->channel_.bytes_received() != heard;
        const bool was_pending = std::exchange(self->is_ping_pending_, !is_heard);
        if (!is_heard && was_pending) {
          self->is_silent_ = true;
          self->close();
          return;
        }
        if (!is_heard) self->send(Ping{});
        self->await_sign();
      });
}

void UpstreamLink::close() {
  channel_.close();
  connect_timer_.cancel();
  silence_timer_.cancel();
}

}  // namespace multitetra
