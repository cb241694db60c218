// The context of TLS connections: a certificate and its key, or the trusted authorities. Opaque:
// created by tls_files.hpp and trust.hpp, used by ByteStream.
#pragma once

#include <memory>

namespace multitetra {

class TlsContext;

// Shared by the connections made with it; a listener may use another one for new connections.
using TlsContextPtr = std::shared_ptr<TlsContext>;

}  // namespace multitetra
