// The gateway's credentials for its upstreams, and the certificates that it accepts.
#pragma once

#include <optional>
#include <string>

#include "common/net/tls_context.hpp"

namespace multitetra {

// Paths as given in options; empty: none.
struct UpstreamFiles {
  std::string ca = {};  // PEM: trusted authorities, instead of the system's.
  // The first line is the gateway's own token.
  std::string token = {};
  bool needs_tls = false;  // Whether any server uses TLS.
};

struct UpstreamSecrets {
  TlsContextPtr tls = nullptr;
  std::optional<std::string> token = {};  // None: clients' tokens are passed on.
};

// Throws ExitError (kBadCredentials), which names the file, if one cannot be used.
[[nodiscard]] UpstreamSecrets load_upstream_secrets(const UpstreamFiles& files);

}  // namespace multitetra
