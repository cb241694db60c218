#include "common/net/trust.hpp"

#include "common/net/stream_socket.hpp"

namespace multitetra {

Result<TlsContextPtr> client_tls(const Trust& trust) {
  auto context = std::make_shared<TlsContext>(asio::ssl::context::tls_client);
  SSL_CTX_set_min_proto_version(context->native_handle(), TLS1_2_VERSION);
  if (trust.insecure) {
    context->set_verify_mode(asio::ssl::verify_none);
    return context;
  }
  context->set_verify_mode(asio::ssl::verify_peer);
  error_code error;
  if (trust.ca_file.empty()) {
    context->set_default_verify_paths(error);
  } else {
    context->load_verify_file(trust.ca_file, error);
  }
  if (error) {
    return fail(ErrorCode::kInvalidArgument,
                trust.ca_file.empty()
                    ? "Cannot read the certificates of this machine: " + error.message() + "."
                    : "Cannot read a certificate from " + trust.ca_file + " (" + error.message() +
                          "); it must be a PEM file of certificates.");
  }
  return context;
}

}  // namespace multitetra
