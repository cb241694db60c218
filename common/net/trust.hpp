// The servers a client trusts over TLS: by default those with a certificate for the requested host
// signed by an authority this machine trusts.
#pragma once

#include <string>

#include "common/base/result.hpp"
#include "common/net/tls_context.hpp"

namespace multitetra {

struct Trust {
  std::string ca_file = {};  // PEM file of authorities; empty: those of the machine.
  // Disables certificate checks. For tests only.
  bool insecure = false;
};

// Returns the context for a client's connections; TLS 1.2 or later. Fails with kInvalidArgument if
// the file has no certificate.
[[nodiscard]] Result<TlsContextPtr> client_tls(const Trust& trust);

}  // namespace multitetra
