#include "server/operations/tls_files.hpp"

#include <array>
#include <ctime>
#include <stdexcept>
#include <string>
#include <string_view>

#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include "common/base/exit_codes.hpp"
#include "common/net/stream_socket.hpp"
#include "server/operations/secret_file.hpp"

namespace multitetra {
namespace {

// The cipher suites of TLS 1.2. All those of TLS 1.3 are accepted.
constexpr const char* kCiphers = "ECDHE+AESGCM:ECDHE+CHACHA20";

ExitError failure(const std::string& what, const std::filesystem::path& file,
                  const std::string& why) {
  ERR_clear_error();
  return ExitError(kBadCredentials, "The " + what + " " + file.string() + " " + why);
}

std::string last_reason() {
  const char* const reason = ERR_reason_error_string(ERR_peek_last_error());
  return reason == nullptr ? "" : std::string(" (") + reason + ")";
}

// Selects "http/1.1" if the client offers it. Other clients connect without ALPN, as listeners
// speak nothing else.
int choose_protocol(SSL*, const unsigned char** chosen, unsigned char* size,
                    const unsigned char* offered, unsigned int offered_size, void*) {
  static constexpr std::array<unsigned char, 9> kAlpnProtocols = {8,   'h', 't', 't', 'p',
                                                                  '/', '1', '.', '1'};
  unsigned char* found = nullptr;
  const int outcome = SSL_select_next_proto(&found, size, kAlpnProtocols.data(),
                                            kAlpnProtocols.size(), offered, offered_size);
  *chosen = found;
  return outcome == OPENSSL_NPN_NEGOTIATED ? SSL_TLSEXT_ERR_OK : SSL_TLSEXT_ERR_NOACK;
}

void take_certificate(SSL_CTX* context, const std::filesystem::path& file) {
  (void)read_secret_file("certificate", file);  // Reports errors, and never blocks.
  if (SSL_CTX_use_certificate_chain_file(context, file.c_str()) != 1) {
    throw failure("certificate", file,
                  "is not a PEM certificate" + last_reason() +
                      "; such a file begins with -----BEGIN CERTIFICATE-----.");
  }
  const X509* const own = SSL_CTX_get0_certificate(context);
  if (X509_cmp_current_time(X509_get0_notAfter(own)) < 0) {
    throw failure("certificate", file, "has expired; renew it.");
  }
  if (X509_cmp_current_time(X509_get0_notBefore(own)) > 0) {
    throw failure("certificate", file, "is not valid yet; check this machine's clock.");
  }
}

void take_key(SSL_CTX* context, const TlsFiles& files) {
  (void)read_secret_file("key", files.key);
  // Prevents OpenSSL from prompting for a pass phrase on the terminal.
  SSL_CTX_set_default_passwd_cb(context, [](char*, int, int, void*) { return 0; });
  if (SSL_CTX_use_PrivateKey_file(context, files.key.c_str(), SSL_FILETYPE_PEM) != 1) {
    const bool is_of_another =
        ERR_GET_REASON(ERR_peek_last_error()) == X509_R_KEY_VALUES_MISMATCH ||
        ERR_GET_REASON(ERR_peek_last_error()) == X509_R_KEY_TYPE_MISMATCH;
    throw failure("key", files.key,
                  is_of_another
                      ? "does not match the certificate " + files.certificate.string() +
                            "; create both together."
                      : "is not a PEM private key without a pass phrase" + last_reason() + ".");
  }
  if (SSL_CTX_check_private_key(context) != 1) {
    throw failure(
        "key", files.key,
        "does not match the certificate " + files.certificate.string() + "; create both together.");
  }
}

}  // namespace

TlsContextPtr load_tls(const TlsFiles& files) {
  ERR_clear_error();
  auto tls = std::make_shared<TlsContext>(asio::ssl::context::tls_server);
  SSL_CTX* const context = tls->native_handle();
  SSL_CTX_set_min_proto_version(context, TLS1_2_VERSION);
  SSL_CTX_set_cipher_list(context, kCiphers);
  SSL_CTX_set_options(context, SSL_OP_NO_COMPRESSION | SSL_OP_NO_RENEGOTIATION |
                                   SSL_OP_CIPHER_SERVER_PREFERENCE | SSL_OP_PRIORITIZE_CHACHA);
  // Idle connections, possibly thousands, release their buffers.
  SSL_CTX_set_mode(context, SSL_MODE_RELEASE_BUFFERS);
  SSL_CTX_set_alpn_select_cb(context, choose_protocol, nullptr);
  take_certificate(context, files.certificate);
  take_key(context, files);
  return tls;
}

std::int64_t expiry_of(TlsContext& tls) {
  const X509* const own = SSL_CTX_get0_certificate(tls.native_handle());
  std::tm expires = {};
  ASN1_TIME_to_tm(X509_get0_notAfter(own), &expires);
  return timegm(&expires);
}

}  // namespace multitetra
