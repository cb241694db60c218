// The byte stream of a connection: TCP, or TLS over TCP.
//
//   ByteStream stream(std::move(accepted), tls);  // tls: null for plain TCP.
//   if (co_await stream.handshake_as_server()) co_return;
//   const Transfer got = co_await stream.read_some(asio::buffer(bytes));
//   if (got.error) ...
//
// As with any socket: at most one read and one write are under way at a time, everything runs on
// the executor of the TCP socket, and the stream outlives what is under way.
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

  // Must be over before the first read or write. Nothing to do for plain TCP.
  [[nodiscard]] asio::awaitable<error_code> handshake_as_server();
  // Whether that failed because HTTP without TLS came.
  [[nodiscard]] static bool was_plain_http(const error_code& error);
  // The handshake of a client, which sends `host` as server name and, unless the context skips
  // verification, requires its certificate. The error is the end of a sentence; kInvalidArgument
  // when a retry is useless. `ca_option` is the option that names an authority.
  [[nodiscard]] asio::awaitable<Result<void>> handshake_as_client(std::string host,
                                                                  std::string ca_option);

  [[nodiscard]] asio::awaitable<Transfer> read_some(asio::mutable_buffer into);
  // All of both, in one go; the bytes stay where they are.
  [[nodiscard]] asio::awaitable<Transfer> write(asio::const_buffer first,
                                                asio::const_buffer second = {});
  // The bytes that were written and not yet sent; 0 if unknown. Bytes under way are not counted,
  // since their acknowledgement may be late.
  [[nodiscard]] std::size_t unsent();
  // Ends the sending direction: TLS's close_notify, or TCP's FIN. With TLS it completes when the
  // other side has done the same, which browsers never do: limit the wait.
  [[nodiscard]] asio::awaitable<error_code> shut_down();
  // Running operations end with an error.
  void close();

  // For what is spoken over it.
  [[nodiscard]] StreamSocket& layer() { return *socket_; }

 private:
  std::unique_ptr<StreamSocket> socket_;
};

// Socket options of all connections: no delay for small messages, and keep-alive.
void set_socket_options(tcp::socket& socket);

}  // namespace multitetra
