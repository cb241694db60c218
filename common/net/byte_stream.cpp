#include "common/net/byte_stream.hpp"

#include <linux/sockios.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <utility>

#include "common/net/stream_socket.hpp"

namespace multitetra {
namespace {

bool is_address(const std::string& host) {
  error_code error;
  asio::ip::make_address(host, error);
  return !error;
}

// Before the handshake: sends `host` as the server name and, unless the context skips verification,
// requires a certificate for it.
void expect_host(SSL* tls, const std::string& host) {
  const bool by_address = is_address(host);
  // Calls SSL_ctrl() since OpenSSL's macro contains an old-style cast. Addresses are not sent as
  // server names.
  if (!by_address) {
    SSL_ctrl(tls, SSL_CTRL_SET_TLSEXT_HOSTNAME, TLSEXT_NAMETYPE_host_name,
             const_cast<char*>(host.c_str()));
  }
  if (SSL_get_verify_mode(tls) == SSL_VERIFY_NONE) return;
  X509_VERIFY_PARAM* const expected = SSL_get0_param(tls);
  if (by_address) {
    X509_VERIFY_PARAM_set1_ip_asc(expected, host.c_str());
  } else {
    X509_VERIFY_PARAM_set_hostflags(expected, X509_CHECK_FLAG_NO_PARTIAL_WILDCARDS);
    X509_VERIFY_PARAM_set1_host(expected, host.c_str(), host.size());
  }
}

std::string handshake_fault(SSL* tls, const error_code& error, const std::string& host,
                            const std::string& ca_option) {
  const long verified = SSL_get_verify_result(tls);
  if (verified == X509_V_OK) return error.message() + "; does this port use TLS?";
  if (verified == X509_V_ERR_HOSTNAME_MISMATCH || verified == X509_V_ERR_IP_ADDRESS_MISMATCH) {
    return "its certificate is not valid for the name " + host +
           "; connect by a name that it lists (subjectAltName), or get a certificate for " + host +
           ".";
  }
  return std::string("its certificate is not trusted (") + X509_verify_cert_error_string(verified) +
         "); give the certificate of its authority with " + ca_option + " FILE.";
}

}  // namespace

ByteStream::ByteStream(tcp::socket socket, TlsContextPtr tls)
    : socket_(std::make_unique<StreamSocket>(std::move(socket), std::move(tls))) {}
ByteStream::~ByteStream() = default;
ByteStream::ByteStream(ByteStream&&) noexcept = default;

asio::any_io_executor ByteStream::executor() { return socket_->get_executor(); }
tcp::socket& ByteStream::socket() { return socket_->socket(); }
bool ByteStream::is_tls() const { return socket_->is_tls(); }

asio::awaitable<error_code> ByteStream::handshake_as_server() {
  error_code error;
  co_await socket_->async_handshake(asio::ssl::stream_base::server, use_error(error));
  co_return error;
}

bool ByteStream::was_plain_http(const error_code& error) {
  return error.category() == asio::error::get_ssl_category() &&
         ERR_GET_REASON(static_cast<unsigned long>(error.value())) == SSL_R_HTTP_REQUEST;
}

asio::awaitable<Result<void>> ByteStream::handshake_as_client(std::string host,
                                                              std::string ca_option) {
  if (!is_tls()) co_return Result<void>();
  expect_host(socket_->native_tls(), host);
  error_code error;
  co_await socket_->async_handshake(asio::ssl::stream_base::client, use_error(error));
  if (!error) co_return Result<void>();
  // A lost server may come back; an invalid certificate stays invalid.
  const bool is_tls_fault = error.category() == asio::error::get_ssl_category();
  co_return fail(is_tls_fault ? ErrorCode::kInvalidArgument : ErrorCode::kUnavailable,
                 handshake_fault(socket_->native_tls(), error, host, ca_option));
}

asio::awaitable<Transfer> ByteStream::read_some(asio::mutable_buffer into) {
  Transfer done;
  done.bytes = co_await socket_->async_read_some(into, use_error(done.error));
  co_return done;
}

asio::awaitable<Transfer> ByteStream::write(asio::const_buffer first, asio::const_buffer second) {
  const std::array<asio::const_buffer, 2> both = {first, second};
  Transfer done;
  done.bytes = co_await asio::async_write(*socket_, both, use_error(done.error));
  co_return done;
}

std::size_t ByteStream::unsent() {
  int bytes = 0;
  if (!socket().is_open() || ::ioctl(socket().native_handle(), SIOCOUTQNSD, &bytes) != 0) return 0;
  return bytes > 0 ? static_cast<std::size_t>(bytes) : 0;
}

bool ByteStream::is_ended_by_peer() {
  tcp_info info{};
  socklen_t size = sizeof info;
  if (!socket().is_open()) return true;
  if (::getsockopt(socket().native_handle(), IPPROTO_TCP, TCP_INFO, &info, &size) != 0) return true;
  return info.tcpi_state != TCP_ESTABLISHED && info.tcpi_state != TCP_FIN_WAIT1 &&
         info.tcpi_state != TCP_FIN_WAIT2;
}

asio::awaitable<error_code> ByteStream::shut_down() {
  error_code error;
  co_await socket_->async_shutdown(use_error(error));
  co_return error;
}

void ByteStream::close() { socket_->close(); }

void set_socket_options(tcp::socket& socket) {
  error_code ignored;
  socket.set_option(tcp::no_delay(true), ignored);
  socket.set_option(asio::socket_base::keep_alive(true), ignored);
}

}  // namespace multitetra
