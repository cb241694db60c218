// The context of TLS connections: a certificate and its key, or the authorities that are
// trusted. Opaque: tls_files.hpp and trust.hpp make one, ByteStream uses it.
#pragma once

#include <memory>

namespace multitetra {

class TlsContext;

// Shared by the connections that were made with it: a listener may take another for the next ones.
using TlsContextPtr = std::shared_ptr<TlsContext>;

}  // namespace multitetra
