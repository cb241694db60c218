#include "server/http/websocket_connection.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include <spdlog/spdlog.h>

namespace multitetra {

using boost::system::error_code;

namespace {

constexpr std::size_t kSmallMessage = 16 * 1024;

void give_back(std::string& memory) {
  if (memory.capacity() > kSmallMessage) {
    std::string().swap(memory);
  } else {
    memory.clear();
  }
}

}  // namespace

WebSocketConnection::WebSocketConnection(std::unique_ptr<StreamSocket> stream, HttpRequest upgrade,
                                         ClientContextPtr client, MessageSessionPtr conversation,
                                         const HttpOptions& options)
    : stream_(std::move(stream)),
      socket_(*stream_),
      upgrade_(std::move(upgrade)),
      client_(std::move(client)),
      session_(std::move(conversation)),
      options_(options) {
  socket_.set_option(websocket::stream_base::timeout{.handshake_timeout = options.handshake_timeout,
                                                     .idle_timeout = options.idle_timeout,
                                                     .keep_alive_pings = true});
  socket_.set_option(websocket::stream_base::decorator([](websocket::response_type& response) {
    response.set(http::field::sec_websocket_protocol,
                 beast::string_view(kSubprotocol.data(), kSubprotocol.size()));
    response.set(http::field::server, "multitetra/" MULTITETRA_VERSION);
  }));
  socket_.binary(true);
  socket_.auto_fragment(false);  // A message is one frame, written from where it lies.
  socket_.read_message_max(std::min(options.max_message_bytes, options.max_hello_bytes));
}

void WebSocketConnection::start(std::function<void()> on_closed) {
  on_closed_ = std::move(on_closed);
  hello_.set(options_.handshake_timeout);
  spawn(&WebSocketConnection::accept_and_read);
}

void WebSocketConnection::spawn(asio::awaitable<void> (WebSocketConnection::*coroutine)()) {
  ++running_coroutines_;
  asio::co_spawn(
      stream_->get_executor(),
      [self = shared_from_this(), coroutine] { return (self.get()->*coroutine)(); },
      [self = shared_from_this()](const std::exception_ptr& trouble) {
        self->coroutine_done(trouble);
      });
}

void WebSocketConnection::end(const Error& why) {
  session_->end(why);
  linger_.set(options_.linger);
}

void WebSocketConnection::keep_time(Clock::time_point now) {
  if (hello_.is_past(now)) {
    hello_.clear();
    if (!session_->is_welcomed()) {
      end({ErrorCode::kUnavailable, "No Hello came in time; it opens a connection."});
    }
  }
  if (write_.is_past(now) || linger_.is_past(now)) close();
}

asio::awaitable<void> WebSocketConnection::accept_and_read() {
  error_code error;
  co_await socket_.async_accept(upgrade_, use_error(error));
  upgrade_ = {};
  if (error) {
    spdlog::info("{}: no WebSocket: {}", session_->peer(), error.message());
    session_->leave();
    co_return;
  }
  spawn(&WebSocketConnection::write);
  co_await read();
}

asio::awaitable<void> WebSocketConnection::read() {
  std::string content;
  for (;;) {
    co_await session_->room();
    auto buffer = asio::dynamic_buffer(content);
    error_code error;
    co_await socket_.async_read(buffer, use_error(error));
    if (error) {
      if (error != websocket::error::closed && !session_->is_over()) {
        spdlog::info("{}: the WebSocket was lost: {}", session_->peer(), error.message());
      }
      break;
    }
    if (session_->is_over()) {
      // What comes after the end is dropped, as closing waits for the client's close frame.
    } else if (!socket_.got_binary()) {
      end({ErrorCode::kMalformedMessage,
           "A text message came; the messages of " + std::string(kSubprotocol) + " are binary."});
    } else {
      session_->receive(content);
      if (session_->is_welcomed()) socket_.read_message_max(options_.max_message_bytes);
    }
    give_back(content);
  }
  session_->leave();
}

asio::awaitable<void> WebSocketConnection::write() {
  while (const auto message = co_await session_->next_message()) {
    const std::string content = serialize(*message);
    if (content.size() > kMaxServerFrameBytes) {
      session_->give_up(*message);
      continue;
    }
    write_.set(options_.write_timeout);
    error_code error;
    co_await socket_.async_write(asio::buffer(content), use_error(error));
    write_.clear();
    if (error) {
      close();
      co_return;
    }
    client_->admission().observer().sent("websocket", content.size());
  }
  linger_.set(options_.linger);
  if (!socket_.is_open()) co_return;
  error_code ignored;
  co_await socket_.async_close(websocket::close_code::normal, use_error(ignored));
}

void WebSocketConnection::close() {
  stream_->close();
  session_->leave();
}

void WebSocketConnection::coroutine_done(const std::exception_ptr& trouble) {
  try {
    if (trouble) std::rethrow_exception(trouble);
  } catch (const std::exception& error) {
    spdlog::error("{}: closing the WebSocket: {}", session_->peer(), error.what());
    close();
  }
  if (--running_coroutines_ > 0) return;
  close();
  on_closed_();
}

}  // namespace multitetra
