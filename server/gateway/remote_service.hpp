// The service of other servers: a client is offered their datasets together; streams and queries
// are forwarded. When a server is lost in the middle of a stream, another one with the same dataset
// continues, and the client notices only a pause.
//
//   Server gateway(remote_service({.upstream = {.upstreams = {...}}}), {}, {http_listener({})});
//
// Memory is bounded: a few messages wait for the client, the following ones in the socket of the
// upstream (back-pressure).
#pragma once

#include "server/gateway/upstream_options.hpp"
#include "server/service/surface_service.hpp"

namespace multitetra {

struct RemoteServiceOptions {
  UpstreamOptions upstream = {};
  // The secrets of `upstream` are read from them, at the start and on reload().
  UpstreamFiles files = {};
  RequestLimits requests = {};
};

// When it is called it throws ExitError if the files cannot be used.
[[nodiscard]] MakeService remote_service(RemoteServiceOptions options);

}  // namespace multitetra
