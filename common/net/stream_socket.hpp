// The implementation of ByteStream. Private to this folder: every template below costs seconds in
// each file that uses it.
//
// Models Asio's AsyncReadStream and AsyncWriteStream, so that asio::async_write and Beast take a
// StreamSocket& as they take a tcp::socket&. Neither copied nor moved: operations under way know
// its address.
//
// As with any socket: at most one read and one write are under way at a time, and everything runs
// on the executor of the TCP socket.
#pragma once

#include <memory>
#include <optional>

#include <boost/asio/ssl.hpp>

#include "common/net/net.hpp"
#include "common/net/tls_context.hpp"

namespace multitetra {

class TlsContext : public asio::ssl::context {
 public:
  using asio::ssl::context::context;
};

class StreamSocket {
 public:
  using executor_type = tcp::socket::executor_type;

  // Plain TCP if `tls` is null.
  explicit StreamSocket(tcp::socket socket, TlsContextPtr tls = nullptr)
      : socket_(std::move(socket)), context_(std::move(tls)) {
    if (context_) tls_.emplace(socket_, *context_);
  }
  StreamSocket(const StreamSocket&) = delete;
  StreamSocket& operator=(const StreamSocket&) = delete;

  [[nodiscard]] executor_type get_executor() { return socket_.get_executor(); }
  [[nodiscard]] tcp::socket& socket() { return socket_; }
  [[nodiscard]] bool is_tls() const { return tls_.has_value(); }
  // For SNI and verification, before the handshake. Requires is_tls().
  [[nodiscard]] SSL* native_tls() { return tls_->native_handle(); }

  // Must be over before the first read or write. Nothing to do for plain TCP.
  template <typename Token>
  auto async_handshake(asio::ssl::stream_base::handshake_type role, Token&& token) {
    return asio::async_initiate<Token, void(boost::system::error_code)>(
        [this, role](auto handler) {
          if (tls_) {
            tls_->async_handshake(role, std::move(handler));
          } else {
            succeed(std::move(handler));
          }
        },
        token);
  }

  template <typename Buffers, typename Token>
  auto async_read_some(const Buffers& buffers, Token&& token) {
    return asio::async_initiate<Token, void(boost::system::error_code, std::size_t)>(
        [this](auto handler, const Buffers& into) {
          if (tls_) {
            tls_->async_read_some(into, std::move(handler));
          } else {
            socket_.async_read_some(into, std::move(handler));
          }
        },
        token, buffers);
  }

  template <typename Buffers, typename Token>
  auto async_write_some(const Buffers& buffers, Token&& token) {
    return asio::async_initiate<Token, void(boost::system::error_code, std::size_t)>(
        [this](auto handler, const Buffers& from) {
          if (tls_) {
            tls_->async_write_some(from, std::move(handler));
          } else {
            socket_.async_write_some(from, std::move(handler));
          }
        },
        token, buffers);
  }

  // Ends the sending direction: TLS's close_notify, or TCP's FIN. With TLS it completes when the
  // other side has done the same, which browsers never do: limit the wait.
  template <typename Token>
  auto async_shutdown(Token&& token) {
    return asio::async_initiate<Token, void(boost::system::error_code)>(
        [this](auto handler) {
          boost::system::error_code ignored;
          if (tls_) {
            tls_->async_shutdown(std::move(handler));
          } else {
            socket_.shutdown(tcp::socket::shutdown_send, ignored);
            succeed(std::move(handler));
          }
        },
        token);
  }

  // Running operations end with an error.
  void close() {
    boost::system::error_code ignored;
    socket_.close(ignored);
  }

 private:
  template <typename Handler>
  void succeed(Handler handler) {
    asio::post(socket_.get_executor(),
               [handler = std::move(handler)]() mutable { handler(boost::system::error_code{}); });
  }

  tcp::socket socket_;
  TlsContextPtr context_;
  std::optional<asio::ssl::stream<tcp::socket&>> tls_;
};

}  // namespace multitetra
