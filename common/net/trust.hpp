// Whom a client believes over TLS: by default a server whose certificate is signed by an authority
// that this machine trusts, and made for the host that was asked for.
#pragma once

#include <string>

#include "common/base/result.hpp"
#include "common/net/tls_context.hpp"

namespace multitetra {

struct Trust {
  std::string ca_file = {};  // PEM, instead of the machine's authorities; empty: those.
  bool insecure = false;     // Whoever answers is believed. For trials only.
};

// What connections are made with; TLS 1.2 or later. kInvalidArgument when the file has no
// certificate.
[[nodiscard]] Result<TlsContextPtr> client_tls(const Trust& trust);

}  // namespace multitetra
