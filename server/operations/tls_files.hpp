// The TLS context of a listener, from the files of a certificate and its key.
//
//   TlsContextPtr tls = load_tls({.certificate = "server.pem", .key = "server.key"});
//   ByteStream stream(std::move(accepted), tls);
//
// TLS 1.2 and 1.3 with forward secrecy, without compression and renegotiation; HTTP/1.1 by ALPN. A
// context never changes: a renewed certificate is another context, for later connections.
#pragma once

#include <filesystem>

#include "common/net/tls_context.hpp"

namespace multitetra {

struct TlsFiles {
  std::filesystem::path certificate;  // PEM: the server's own, then those that lead to the root.
  std::filesystem::path key;          // PEM, without a pass phrase.
};

// Throws ExitError (kNoSecrets) with the file and its fault: it is missing, no PEM, a key of
// another certificate, or a certificate that has expired.
[[nodiscard]] TlsContextPtr load_tls(const TlsFiles& files);

}  // namespace multitetra
