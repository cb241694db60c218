#include "common/net/trust.hpp"

namespace multitetra {
namespace {

bool is_address(const std::string& host) {
  boost::system::error_code error;
  asio::ip::make_address(host, error);
  return !error;
}

}  // namespace

Result<TlsContextPtr> client_tls(const Trust& trust) {
  auto context = std::make_shared<asio::ssl::context>(asio::ssl::context::tls_client);
  SSL_CTX_set_min_proto_version(context->native_handle(), TLS1_2_VERSION);
  if (trust.insecure) {
    context->set_verify_mode(asio::ssl::verify_none);
    return context;
  }
  context->set_verify_mode(asio::ssl::verify_peer);
  boost::system::error_code error;
  if (trust.ca_file.empty()) {
    context->set_default_verify_paths(error);
  } else {
    context->load_verify_file(trust.ca_file, error);
  }
  if (error) {
    return fail(ErrorCode::kInvalidArgument,
                trust.ca_file.empty()
                    ? "The certificates of this machine cannot be read: " + error.message() + "."
                    : "No certificate can be read from " + trust.ca_file + " (" + error.message() +
                          "); it must be a PEM file of certificates.");
  }
  return context;
}

void expect_host(StreamSocket& stream, const std::string& host) {
  SSL* const tls = stream.native_tls();
  const bool by_address = is_address(host);
  // A macro of OpenSSL's with a cast of its own; addresses are not asked for by name.
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

std::string handshake_fault(StreamSocket& stream, const boost::system::error_code& error,
                            const std::string& ca_option) {
  const long verified = SSL_get_verify_result(stream.native_tls());
  if (verified == X509_V_OK) return error.message() + "; does it speak TLS?";
  return std::string("its certificate is not to be trusted (") +
         X509_verify_cert_error_string(verified) +
         "); give the certificate of its authority with " + ca_option + " FILE.";
}

}  // namespace multitetra
