// Whom a client believes over TLS: by default a server whose certificate is signed by an authority
// that this machine trusts, and made for the host that was asked for.
#pragma once

#include <string>

#include "common/base/result.hpp"
#include "common/net/stream_socket.hpp"

namespace multitetra {

struct Trust {
  std::string ca_file = {};  // PEM, instead of the machine's authorities; empty: those.
  bool insecure = false;     // Whoever answers is believed. For trials only.
};

// What connections are made with; TLS 1.2 or later. kInvalidArgument when the file has no
// certificate.
[[nodiscard]] Result<TlsContextPtr> client_tls(const Trust& trust);

// Before the handshake: asks for the certificate of `host` and, unless the context believes
// everybody, will accept no other. Requires stream.is_tls().
void expect_host(StreamSocket& stream, const std::string& host);

// Why the handshake failed, as the end of a sentence. `ca_option` is how users name an authority.
[[nodiscard]] std::string handshake_fault(StreamSocket& stream,
                                          const boost::system::error_code& error,
                                          const std::string& ca_option = "--ca");

}  // namespace multitetra
