// The gateway's credentials at its upstreams, and the certificates that it accepts.
#pragma once

#include <optional>
#include <string>

#include "common/net/tls_context.hpp"

namespace multitetra {

// Files, as options name them; empty: none.
struct UpstreamFiles {
  std::string ca = {};     // PEM: authorities that are trusted instead of the machine's.
  std::string token = {};  // The gateway's own token, in its first line.
  bool needs_tls = false;  // Whether a server speaks TLS.
};

struct UpstreamSecrets {
  TlsContextPtr tls = nullptr;
  std::optional<std::string> token = {};  // None: servers are shown what clients show.
};

// Throws ExitError (kNoSecrets) that names the file when one cannot be used.
[[nodiscard]] UpstreamSecrets load_upstream_secrets(const UpstreamFiles& files);

}  // namespace multitetra
