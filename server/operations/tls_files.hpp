// Makes a listener's TLS context from certificate and key files.
//
//   TlsContextPtr tls = load_tls({.certificate = "server.pem", .key = "server.key"});
//   ByteStream stream(std::move(accepted), tls);
//
// TLS 1.2 and 1.3 with forward secrecy, without compression and renegotiation; HTTP/1.1 by ALPN. A
// context is immutable: a renewed certificate gives a new context for later connections.
#pragma once

#include <cstdint>
#include <filesystem>

#include "common/net/tls_context.hpp"

namespace multitetra {

struct TlsFiles {
  std::filesystem::path certificate;  // PEM: the server's own, then the chain.
  std::filesystem::path key;          // PEM, without a pass phrase.
};

// Throws ExitError (kBadCredentials) with the file and the fault: missing, not PEM, a key of
// another certificate, or an expired certificate.
[[nodiscard]] TlsContextPtr load_tls(const TlsFiles& files);

// Returns when the own certificate of a context of load_tls() expires, in seconds of Unix time.
[[nodiscard]] std::int64_t expiry_of(TlsContext& tls);

}  // namespace multitetra
