// The servers that a client trusts over TLS: by default those with a certificate for the requested
// host that is signed by an authority which this machine trusts.
#pragma once

#include <string>

#include "common/base/result.hpp"
#include "common/net/tls_context.hpp"

namespace multitetra {

struct Trust {
  std::string ca_file = {};  // PEM, instead of the machine's authorities; empty: those.
  bool insecure = false;     // Certificates are not checked. For trials only.
};

// The context of a client's connections; TLS 1.2 or later. kInvalidArgument when the file has no
// certificate.
[[nodiscard]] Result<TlsContextPtr> client_tls(const Trust& trust);

}  // namespace multitetra
