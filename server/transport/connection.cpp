#include "server/transport/connection.hpp"

#include <algorithm>

#include "server/operations/log.hpp"

namespace multitetra {

using boost::system::error_code;

Connection::Connection(tcp::socket socket, TlsContextPtr tls, ClientContextPtr client,
                       MessageSessionPtr conversation, ConnectionOptions options)
    : stream_(std::move(socket), std::move(tls)),
      client_(std::move(client)),
      session_(std::move(conversation)),
      options_(options),
      handshake_timer_(stream_.get_executor()),
      write_timer_(stream_.get_executor()),
      linger_timer_(stream_.get_executor()) {
  error_code ignored;
  stream_.socket().set_option(tcp::no_delay(true), ignored);
  stream_.socket().set_option(asio::socket_base::keep_alive(true), ignored);
  if (options_.send_buffer_bytes) {
    stream_.socket().set_option(asio::socket_base::send_buffer_size(*options_.send_buffer_bytes),
                                ignored);
  }
}

void Connection::start(std::function<void()> on_closed) {
  on_closed_ = std::move(on_closed);
  const auto self = shared_from_this();
  handshake_timer_.expires_after(options_.handshake_timeout);
  handshake_timer_.async_wait([self](error_code cancelled) {
    if (cancelled || self->session_->is_welcomed()) return;
    self->end({ErrorCode::kUnavailable, "No Hello came in time; it opens a connection."});
  });
  spawn(&Connection::greet_and_read);
}

void Connection::spawn(asio::awaitable<void> (Connection::*coroutine)()) {
  ++running_coroutines_;
  asio::co_spawn(
      stream_.get_executor(),
      [self = shared_from_this(), coroutine] { return (self.get()->*coroutine)(); },
      [self = shared_from_this()](const std::exception_ptr& trouble) {
        self->coroutine_done(trouble);
      });
}

void Connection::end(const Error& error) {
  session_->end(error);
  close_after(linger_timer_, options_.linger);
}

asio::awaitable<void> Connection::greet_and_read() {
  error_code error;
  co_await stream_.async_handshake(asio::ssl::stream_base::server, use_error(error));
  if (error) {
    log_line(LogLevel::kInfo, "no TLS: " + error.message(),
             {{"connection", client_->facts().connection}, {"peer", client_->facts().peer}});
    session_->leave();
    co_return;
  }
  spawn(&Connection::write);
  co_await read();
}

asio::awaitable<void> Connection::read() {
  FrameReader frames(std::min(options_.max_message_bytes, options_.max_hello_bytes));
  std::array<char, 16 * 1024> buffer{};
  for (;;) {
    co_await session_->room();
    error_code error;
    const std::size_t size =
        co_await stream_.async_read_some(asio::buffer(buffer), use_error(error));
    if (error) break;
    // What comes after the end is read and dropped: closing with unread bytes would reset the
    // connection and take our last words away from the client.
    if (session_->is_over()) continue;
    frames.feed({buffer.data(), size});
    co_await receive_frames(frames);
  }
  if (frames.buffered() > 0) {
    log_line(LogLevel::kInfo, "left inside a message",
             {{"connection", client_->facts().connection}, {"peer", client_->facts().peer}});
  }
  session_->leave();
}

asio::awaitable<void> Connection::receive_frames(FrameReader& frames) {
  while (!session_->is_over()) {
    const auto content = frames.next();
    if (!content) {
      session_->end(content.error());
    } else if (*content) {
      session_->receive(**content);
      if (session_->is_welcomed()) frames.set_limit(options_.max_message_bytes);
      co_await session_->room();
    } else {
      break;
    }
  }
}

asio::awaitable<void> Connection::write() {
  while (const auto message = co_await session_->next_message()) {
    const std::string content = serialize(*message);
    if (content.size() > kMaxServerFrameBytes) {
      session_->give_up(*message);
      continue;
    }
    const std::string header = frame_header(static_cast<std::uint32_t>(content.size()));
    const std::array<asio::const_buffer, 2> frame = {asio::buffer(header), asio::buffer(content)};
    close_after(write_timer_, options_.write_timeout);
    error_code error;
    co_await asio::async_write(stream_, frame, use_error(error));
    write_timer_.cancel();
    if (error) {
      close();
      co_return;
    }
    client_->admission().observer().sent("tcp", header.size() + content.size());
  }
  close_after(linger_timer_, options_.linger);
  error_code ignored;
  co_await stream_.async_shutdown(use_error(ignored));
}

void Connection::close_after(asio::steady_timer& timer, std::chrono::milliseconds delay) {
  timer.expires_after(delay);
  timer.async_wait([self = shared_from_this()](error_code cancelled) {
    if (!cancelled) self->close();
  });
}

void Connection::close() {
  stream_.close();
  session_->leave();
}

void Connection::coroutine_done(const std::exception_ptr& trouble) {
  try {
    if (trouble) std::rethrow_exception(trouble);
  } catch (const std::exception& error) {
    log_line(LogLevel::kError, std::string("closing the connection: ") + error.what(),
             {{"connection", client_->facts().connection}, {"peer", client_->facts().peer}});
    close();
  }
  if (--running_coroutines_ > 0) return;
  handshake_timer_.cancel();
  write_timer_.cancel();
  linger_timer_.cancel();
  close();
  on_closed_();
}

}  // namespace multitetra
