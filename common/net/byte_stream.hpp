// The byte stream of a connection: TCP, or TLS over TCP.
//
//   ByteStream stream(std::move(accepted), tls);  // tls: null for plain TCP.
//   if (co_await stream.handshake_as_server()) co_return;
//   const Transfer got = co_await stream.read_some(asio::buffer(bytes));
//   if (got.error) ...
//
// As with any socket, at most one read and one write may be in progress, everything runs on the
// executor of the TCP socket, and the stream must outlive its operations.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <string>

#include "common/base/result.hpp"
#include "common/net/net.hpp"
#include "common/net/tls_context.hpp"

namespace multitetra {

class StreamSocket;

// The number of transferred bytes, and the error that ended the transfer.
struct Transfer {
  std::size_t bytes = 0;
  error_code error = {};
};

class ByteStream {
 public:
  // Plain TCP if `tls` is null.
  explicit ByteStream(tcp::socket socket, TlsContextPtr tls = nullptr);
  ~ByteStream();
  ByteStream(ByteStream&&) noexcept;
  ByteStream& operator=(ByteStream&&) = delete;

  [[nodiscard]] asio::any_io_executor executor();
  [[nodiscard]] tcp::socket& socket();
  [[nodiscard]] bool is_tls() const;

  // Must complete before the first read or write. Does nothing for plain TCP.
  [[nodiscard]] asio::awaitable<error_code> handshake_as_server();
  // Returns whether the handshake failed because of plain HTTP.
  [[nodiscard]] static bool was_plain_http(const error_code& error);
  // Performs the client's handshake. Sends `host` as the server name and, unless the context skips
  // verification, requires a certificate for it. Errors end a sentence; kInvalidArgument means that
  // retrying is useless. `ca_option` is the name of the option for a certificate authority.
  [[nodiscard]] asio::awaitable<Result<void>> handshake_as_client(std::string host,
                                                                  std::string ca_option);

  [[nodiscard]] asio::awaitable<Transfer> read_some(asio::mutable_buffer into);
  // Writes both buffers completely. The bytes must stay valid until then.
  [[nodiscard]] asio::awaitable<Transfer> write(asio::const_buffer first,
                                                asio::const_buffer second = {});
  // Returns the number of bytes written but not yet sent; 0 if unknown. Excludes bytes in flight,
  // whose acknowledgement may be late.
  [[nodiscard]] std::size_t unsent();
  // Returns whether the peer has ended its sending direction or the connection, also if bytes from
  // before are still unread.
  [[nodiscard]] bool is_ended_by_peer();
  // Ends the sending direction with TLS's close_notify or TCP's FIN. With TLS it completes only
  // when the peer does the same, which browsers never do: limit the wait.
  [[nodiscard]] asio::awaitable<error_code> shut_down();
  // Pending operations end with an error.
  void close();

  // Returns the socket, for protocols on top of this stream.
  [[nodiscard]] StreamSocket& layer() { return *socket_; }

 private:
  std::unique_ptr<StreamSocket> socket_;
};

// Sets the options of all connections: no delay for small messages, and keep-alive.
void set_socket_options(tcp::socket& socket);

}  // namespace multitetra
