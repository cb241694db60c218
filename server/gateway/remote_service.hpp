// The service by other servers. Clients are offered the union of their datasets; streams and
// queries are forwarded. If a server is lost during a stream, another one with the same dataset
// continues it, and the client notices only a pause.
//
//   Server gateway(remote_service({.upstream = {.upstreams = {...}}}), {}, {http_listener({})});
//
// Memory is bounded: a few messages are queued per client, the rest wait in the upstream's socket
// (back-pressure).
#pragma once

#include "server/gateway/upstream_options.hpp"
#include "server/service/surface_service.hpp"

namespace multitetra {

struct RemoteServiceOptions {
  UpstreamOptions upstream = {};
  // The secrets of `upstream` are loaded from these files at the start and on reload().
  UpstreamFiles files = {};
  RequestLimits requests = {};
};

// Returns the service. The result throws ExitError when called if the files cannot be used.
[[nodiscard]] MakeService remote_service(RemoteServiceOptions options);

}  // namespace multitetra
