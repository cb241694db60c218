#include "server/transport/message_connection.hpp"

#include "common/net/coroutines.hpp"

#include <algorithm>
#include <exception>
#include <utility>

namespace multitetra {

MessageConnection::MessageConnection(std::unique_ptr<ByteStream> stream, OpenTransport open,
                                     ConnectionContextPtr client, SessionRunnerPtr session_runner,
                                     ConnectionOptions options)
    : stream_(std::move(stream)),
      open_(std::move(open)),
      client_(std::move(client)),
      session_runner_(std::move(session_runner)),
      options_(options) {
  set_socket_options(stream_->socket());
  if (options_.send_buffer_bytes) {
    error_code ignored;
    stream_->socket().set_option(asio::socket_base::send_buffer_size(*options_.send_buffer_bytes),
                                 ignored);
  }
}

void MessageConnection::start(std::function<void()> on_closed) {
  on_closed_ = std::move(on_closed);
  allow_idle_eviction(*client_, weak_from_this());
  hello_.set(options_.handshake_timeout);
  spawn(&MessageConnection::open_and_read);
}

void MessageConnection::spawn(asio::awaitable<void> (MessageConnection::*coroutine)()) {
  ++running_coroutines_;
  multitetra::spawn(
      stream_->executor(),
      [self = shared_from_this(), coroutine] { return (self.get()->*coroutine)(); },
      [self = shared_from_this()](const std::exception_ptr& failure) {
        self->coroutine_done(failure);
      });
}

void MessageConnection::end(const Error& why) {
  session_runner_->end(why);
  linger_.set(options_.linger);
}

void MessageConnection::enforce_limits(Clock::time_point now) {
  if (hello_.is_past(now)) {
    hello_.clear();
    if (!session_runner_->is_welcomed()) {
      end({ErrorCode::kUnavailable, "The first message did not arrive in time."});
      return;  // The linger time begins now.
    }
  }
  if (write_.is_past(now) || linger_.is_past(now)) {
    close();
  } else {
    session_runner_->enforce_limits(now);
  }
}

asio::awaitable<void> MessageConnection::open_and_read() {
  auto opened = co_await open_(
      *stream_, TransportOptions{.max_message_bytes = std::min(session_runner_->max_message_bytes(),
                                                               options_.max_hello_bytes),
                                 .read_buffer_bytes = 16 * 1024});
  open_ = {};
  if (!opened) {
    log(LogLevel::kInfo, opened.error().text);
    session_runner_->on_disconnect();
    co_return;
  }
  transport_ = *std::move(opened);
  spawn(&MessageConnection::write);
  co_await read();
}

asio::awaitable<void> MessageConnection::read() {
  for (;;) {
    co_await session_runner_->until_readable();
    const Result<std::string> content = co_await transport_->receive();
    if (!content) {
      if (content.error().code == ErrorCode::kUnavailable) break;
      if (!session_runner_->is_over()) end(content.error());
      co_await transport_->drain();
      break;
    }
    if (session_runner_->is_over()) continue;  // Drops input after the end.
    session_runner_->receive(*content);
    if (session_runner_->is_welcomed()) transport_->set_limit(session_runner_->max_message_bytes());
  }
  if (transport_->was_cut_off() && !session_runner_->is_over()) {
    log(LogLevel::kInfo, "connection closed within a message");
  }
  session_runner_->on_disconnect();
}

asio::awaitable<void> MessageConnection::write() {
  while (const auto message = co_await session_runner_->next_message()) {
    std::string content = serialize(*message);
    if (content.size() > kMaxServerFrameBytes) {
      session_runner_->reject_oversized_reply(*message);
      continue;
    }
    write_.set(options_.write_timeout);
    link_.write_begins(Clock::now(), stream_->unsent());
    const Result<std::size_t> sent = co_await transport_->send(std::move(content));
    write_.clear();
    if (!sent) {
      close();
      co_return;
    }
    link_.write_ends(Clock::now(), *sent, stream_->unsent());
    session_runner_->set_bandwidth(link_.bytes_per_second());
    client_->admission().observer().sent(client_->facts().protocol, *sent);
  }
  linger_.set(options_.linger);
  co_await transport_->close_gracefully();
}

void MessageConnection::close() {
  stream_->close();
  session_runner_->on_disconnect();
}

void MessageConnection::coroutine_done(const std::exception_ptr& failure) {
  try {
    if (failure) std::rethrow_exception(failure);
  } catch (const std::exception& error) {
    log(LogLevel::kError, std::string("closing the connection: ") + error.what());
    close();
  }
  if (--running_coroutines_ > 0) return;
  close();
  on_closed_();
}

void MessageConnection::log(LogLevel level, const std::string& text) const {
  log_line_about(client_->facts().peer, level, text,
                 {{"connection", client_->facts().connection}, {"peer", client_->facts().peer}});
}

}  // namespace multitetra
