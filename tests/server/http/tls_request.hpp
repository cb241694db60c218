// A TLS client that sends raw text to a listener, and the listener's certificate.
#pragma once

#include <string>
#include <string_view>

#include <boost/asio/ssl.hpp>

#include "common/net/net.hpp"
#include "server/operations/tls_files.hpp"
#include "tests/support/certificates.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra::testing {

// A self-signed certificate and its key, as files.
class ListenerCertificate {
 public:
  [[nodiscard]] const TlsFiles& files() const { return files_; }
  [[nodiscard]] const std::string& pem() const { return made_.certificate; }

 private:
  CertificateAndKey made_ = self_signed();
  TemporaryFolder folder_;
  TlsFiles files_ = {folder_.file("cert.pem", made_.certificate),
                     folder_.file("cert.key", made_.key)};
};

class TlsRequest {
 public:
  // Trusts only this certificate.
  TlsRequest(std::uint16_t port, const ListenerCertificate& certificate) {
    context_.add_certificate_authority(asio::buffer(certificate.pem()));
    context_.set_verify_mode(asio::ssl::verify_peer);
    stream_.emplace(io_, context_);
    stream_->next_layer().connect({asio::ip::make_address("127.0.0.1"), port});
    stream_->handshake(asio::ssl::stream_base::client);
  }

  void send(std::string_view text) { asio::write(*stream_, asio::buffer(text)); }
  // Reads until the listener sends close_notify; throws if the connection ends without it.
  [[nodiscard]] std::string read_to_end() {
    std::string answer;
    boost::system::error_code error;
    asio::read(*stream_, asio::dynamic_buffer(answer), error);
    if (error != asio::error::eof) throw boost::system::system_error(error);
    return answer;
  }
  // Sends close_notify and closes the connection, without awaiting the listener's.
  void leave() {
    stream_->async_shutdown([](boost::system::error_code) {});
    io_.poll();
    stream_->next_layer().close();
  }
  // Sends close_notify as well; returns whether the listener has closed the connection.
  [[nodiscard]] bool parts_well() {
    boost::system::error_code error;
    stream_->shutdown(error);
    char byte = 0;
    stream_->next_layer().read_some(asio::buffer(&byte, 1), error);
    return error == asio::error::eof;
  }

 private:
  asio::io_context io_;
  asio::ssl::context context_{asio::ssl::context::tls_client};
  std::optional<asio::ssl::stream<tcp::socket>> stream_;
};

inline constexpr std::string_view kAskWhetherAlive =
    "GET /livez HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n";

}  // namespace multitetra::testing
