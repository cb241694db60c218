#include "server/gateway/http_connection.hpp"

#include <utility>

#include <spdlog/spdlog.h>

namespace multitetra {

using boost::system::error_code;

HttpConnection::HttpConnection(std::unique_ptr<StreamSocket> stream, std::string peer,
                               HttpService& service, const HttpOptions& options)
    : stream_(std::move(stream)),
      peer_(std::move(peer)),
      service_(service),
      options_(options),
      requests_(options.max_header_bytes) {
  error_code ignored;
  stream_->socket().set_option(tcp::no_delay(true), ignored);
  stream_->socket().set_option(asio::socket_base::keep_alive(true), ignored);
  if (options_.send_buffer_bytes) {
    stream_->socket().set_option(asio::socket_base::send_buffer_size(*options_.send_buffer_bytes),
                                 ignored);
  }
}

void HttpConnection::start(Upgrade on_upgrade, std::function<void()> on_closed) {
  on_upgrade_ = std::move(on_upgrade);
  on_closed_ = std::move(on_closed);
  asio::co_spawn(
      stream_->get_executor(), [self = shared_from_this()] { return self->run(); },
      [self = shared_from_this()](const std::exception_ptr& trouble) {
        try {
          if (trouble) std::rethrow_exception(trouble);
        } catch (const std::exception& error) {
          spdlog::error("{}: closing the connection: {}", self->peer_, error.what());
          self->upgrade_.reset();
        }
        if (self->upgrade_) {
          self->on_upgrade_(std::move(self->stream_), *std::move(self->upgrade_));
        } else {
          self->stream_->close();
          self->on_closed_();
        }
      });
}

void HttpConnection::end(const Error&) {
  is_ending_ = true;
  if (!is_answering_) stream_->close();  // Idle, or inside a request that nobody reads any more.
}

void HttpConnection::keep_time(Clock::time_point now) {
  if (!deadline_.is_past(now)) return;
  spdlog::debug("{}: closing the connection: it took too long", peer_);
  deadline_.clear();
  stream_->close();
}

asio::awaitable<void> HttpConnection::run() {
  deadline_.set(options_.handshake_timeout);
  error_code error;
  co_await stream_->async_handshake(asio::ssl::stream_base::server, use_error(error));
  if (error) {
    spdlog::info("{}: no TLS: {}", peer_, error.message());
    co_return;
  }
  while (auto request = co_await read_request()) {
    is_answering_ = true;
    deadline_.clear();
    const std::string request_id = service_.new_request_id();
    const Outcome outcome = co_await service_.answer(*request, request_id);
    const auto* answer = std::get_if<Answer>(&outcome);
    if (!answer) {
      upgrade_ = std::move(request);
      co_return;
    }
    const bool keep_alive = request->keep_alive() && !is_ending_;
    const bool with_body = request->method() != http::verb::head;
    if (!co_await write(*answer, with_body, keep_alive) || !keep_alive) break;
    is_answering_ = false;
  }
  co_await hang_up();
}

asio::awaitable<std::optional<HttpRequest>> HttpConnection::read_request() {
  deadline_.set(options_.keep_alive_timeout);
  std::array<char, 8 * 1024> buffer;  // NOLINT: it is read into before it is looked at.
  bool is_inside = false;
  for (;;) {
    auto request = requests_.next();
    if (!request) {
      const BrokenRequest& broken = request.error();
      is_answering_ = true;
      co_await write(error_answer(broken.status, {ErrorCode::kMalformedMessage, broken.text},
                                  service_.new_request_id()),
                     /*with_body=*/true, /*keep_alive=*/false);
      co_return std::nullopt;
    }
    if (*request) co_return std::move(**request);
    if (requests_.is_inside() && !std::exchange(is_inside, true)) {
      deadline_.set(options_.handshake_timeout);
    }
    error_code error;
    const std::size_t size =
        co_await stream_->async_read_some(asio::buffer(buffer), use_error(error));
    if (error) co_return std::nullopt;
    requests_.feed({buffer.data(), size});
  }
}

asio::awaitable<bool> HttpConnection::write(const Answer& answer, bool with_body, bool keep_alive) {
  const std::string head = head_of(answer, keep_alive);
  std::array<asio::const_buffer, 2> parts = {asio::buffer(head), asio::const_buffer()};
  if (with_body) {
    if (const auto* shared = std::get_if<SharedBytes>(&answer.body)) {
      if (*shared) parts[1] = asio::buffer(**shared);
    } else {
      parts[1] = asio::buffer(std::get<std::string>(answer.body));
    }
  }
  deadline_.set(options_.write_timeout);
  error_code error;
  co_await asio::async_write(*stream_, parts, use_error(error));
  co_return !error;
}

// What the client still sends is read and dropped for a moment: closing with unread bytes would
// reset the connection and take our last words away from it.
asio::awaitable<void> HttpConnection::hang_up() {
  deadline_.set(options_.linger);
  error_code error;
  co_await stream_->async_shutdown(use_error(error));
  std::array<char, 1024> dropped;  // NOLINT: nobody looks at it.
  while (!error) {
    co_await stream_->socket().async_read_some(asio::buffer(dropped), use_error(error));
  }
}

}  // namespace multitetra
