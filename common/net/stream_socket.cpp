#include "common/net/stream_socket.hpp"

namespace multitetra {

void StreamSocket::handshake(asio::ssl::stream_base::handshake_type role, IoHandler handler) {
  if (tls_) {
    tls_->async_handshake(role, std::move(handler));
  } else {
    succeed(std::move(handler));
  }
}

void StreamSocket::read_some(const FirstBuffers<asio::mutable_buffer>& into, IoHandler handler) {
  if (tls_) {
    tls_->async_read_some(into, std::move(handler));
  } else {
    socket_.async_read_some(into, std::move(handler));
  }
}

void StreamSocket::write_some(const FirstBuffers<asio::const_buffer>& from, IoHandler handler) {
  if (tls_) {
    tls_->async_write_some(from, std::move(handler));
  } else {
    socket_.async_write_some(from, std::move(handler));
  }
}

void StreamSocket::shut_down(IoHandler handler) {
  if (tls_) {
    tls_->async_shutdown(std::move(handler));
  } else {
    error_code ignored;
    socket_.shutdown(tcp::socket::shutdown_send, ignored);
    succeed(std::move(handler));
  }
}

void StreamSocket::succeed(IoHandler handler) {
  asio::post(socket_.get_executor(),
             [handler = std::move(handler)]() mutable { handler(error_code{}); });
}

}  // namespace multitetra
