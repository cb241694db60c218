#include "server/operations/tls_files.hpp"

#include <sys/stat.h>

#include <functional>
#include <thread>

#include <gtest/gtest.h>

#include "common/base/exit_codes.hpp"
#include "common/net/stream_socket.hpp"
#include "server/operations/access_list.hpp"
#include "tests/support/certificates.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

using testing::CertificateAndKey;
using testing::self_signed;

class TlsFilesTest : public ::testing::Test {
 protected:
  TlsFiles files(const std::string& certificate, const std::string& key) const {
    return {.certificate = folder_.file("server.pem", certificate),
            .key = folder_.file("server.key", key)};
  }
  // The error message for invalid files.
  static std::string refusal(const TlsFiles& files) {
    try {
      (void)load_tls(files);
      return "They were taken.";
    } catch (const std::runtime_error& error) {
      return error.what();
    }
  }

  TemporaryFolder folder_;
  CertificateAndKey good_ = self_signed();
};

// The result of a TLS handshake between a client and the server over a TCP connection.
struct Handshake {
  boost::system::error_code server;
  boost::system::error_code client;
  std::string version;   // The version that the client negotiated.
  std::string protocol;  // Chosen by ALPN.
};

Handshake perform_handshake(const TlsContextPtr& tls,
                            const std::function<void(asio::ssl::context&)>& prepare) {
  asio::io_context io(1);
  tcp::acceptor acceptor(io, {asio::ip::address_v4::loopback(), 0});
  tcp::socket connecting(io);
  connecting.connect(acceptor.local_endpoint());
  StreamSocket server(acceptor.accept(), tls);
  auto context = std::make_shared<TlsContext>(asio::ssl::context::tls_client);
  prepare(*context);
  StreamSocket client(std::move(connecting), context);
  Handshake result;
  server.async_handshake(asio::ssl::stream_base::server, [&](boost::system::error_code error) {
    result.server = error;
    if (error) server.close();
  });
  client.async_handshake(asio::ssl::stream_base::client, [&](boost::system::error_code error) {
    result.client = error;
    if (error) client.close();
  });
  io.run();
  result.version = SSL_get_version(client.native_tls());
  const unsigned char* chosen = nullptr;
  unsigned int size = 0;
  SSL_get0_alpn_selected(client.native_tls(), &chosen, &size);
  result.protocol.assign(reinterpret_cast<const char*>(chosen), size);
  return result;
}

TEST_F(TlsFilesTest, NegotiatesTls13) {
  const Handshake shaken = perform_handshake(
      load_tls(files(good_.certificate, good_.key)), [&](asio::ssl::context& client) {
        client.add_certificate_authority(asio::buffer(good_.certificate));
        client.set_verify_mode(asio::ssl::verify_peer);
        client.set_verify_callback(asio::ssl::host_name_verification("localhost"));
      });
  EXPECT_FALSE(shaken.server) << shaken.server.message();
  EXPECT_FALSE(shaken.client) << shaken.client.message();
  EXPECT_EQ(shaken.version, "TLSv1.3");
  EXPECT_EQ(shaken.protocol, "");
}

TEST_F(TlsFilesTest, AcceptsTls12AndNothingOlder) {
  const TlsContextPtr tls = load_tls(files(good_.certificate, good_.key));
  const auto at_most = [&](int version) {
    return perform_handshake(tls, [&](asio::ssl::context& client) {
      SSL_CTX_set_min_proto_version(client.native_handle(), TLS1_VERSION);
      SSL_CTX_set_max_proto_version(client.native_handle(), version);
      SSL_CTX_set_cipher_list(client.native_handle(), "ALL:@SECLEVEL=0");
    });
  };
  EXPECT_FALSE(at_most(TLS1_2_VERSION).client);
  EXPECT_TRUE(at_most(TLS1_1_VERSION).client);
}

TEST_F(TlsFilesTest, NegotiatesOnlyHttp11) {
  const TlsContextPtr tls = load_tls(files(good_.certificate, good_.key));
  const auto offered = [&](const std::string& protocols) {
    return perform_handshake(tls, [&](asio::ssl::context& client) {
      SSL_CTX_set_alpn_protos(client.native_handle(),
                              reinterpret_cast<const unsigned char*>(protocols.data()),
                              static_cast<unsigned int>(protocols.size()));
    });
  };
  EXPECT_EQ(offered("\x02h2\x08http/1.1").protocol, "http/1.1");
  const Handshake other = offered("\x02h2");
  EXPECT_FALSE(other.client);
  EXPECT_EQ(other.protocol, "");
}

TEST_F(TlsFilesTest, NamesTheInvalidFileAndTheReason) {
  const CertificateAndKey other = self_signed();
  const CertificateAndKey old = self_signed("DNS:localhost", -60);
  const auto has = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  TlsFiles missing = files(good_.certificate, good_.key);
  missing.certificate = folder_.path() / "nowhere.pem";
  EXPECT_TRUE(has(refusal(missing), "nowhere.pem does not exist")) << refusal(missing);
  missing = files(good_.certificate, good_.key);
  missing.key = folder_.path();
  EXPECT_TRUE(has(refusal(missing), "cannot be read")) << refusal(missing);
  EXPECT_TRUE(has(refusal(files("", good_.key)), "is not a PEM certificate"));
  EXPECT_TRUE(has(refusal(files(good_.key, good_.key)), "is not a PEM certificate"));
  EXPECT_TRUE(has(refusal(files(good_.certificate, "")), "is not a PEM private key"));
  EXPECT_TRUE(has(refusal(files(good_.certificate, other.key)), "does not match the certificate"));
  EXPECT_TRUE(has(refusal(files(old.certificate, old.key)), "has expired"));
  const CertificateAndKey early = self_signed("DNS:localhost", 7200, /*from_seconds=*/3600);
  EXPECT_TRUE(has(refusal(files(early.certificate, early.key)), "is not valid yet"));
}

// Reading one would block forever or never reach an end.
TEST_F(TlsFilesTest, RejectsIrregularFiles) {
  const std::filesystem::path pipe = folder_.path() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  for (const std::filesystem::path& file : {pipe, std::filesystem::path("/dev/zero")}) {
    TlsFiles odd = files(good_.certificate, good_.key);
    odd.certificate = file;
    EXPECT_NE(refusal(odd).find("it is not a regular file"), std::string::npos) << refusal(odd);
    odd = files(good_.certificate, good_.key);
    odd.key = file;
    EXPECT_NE(refusal(odd).find("it is not a regular file"), std::string::npos) << refusal(odd);
    EXPECT_THROW((void)load_access_list(file), ExitError);
  }
  EXPECT_NE(refusal(files(std::string((std::size_t{16} << 20) + 1, 'x'), good_.key))
                .find("more than 16 MiB"),
            std::string::npos);
}

}  // namespace
}  // namespace multitetra
