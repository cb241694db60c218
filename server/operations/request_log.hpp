// Writes what a service tells about its work into the log, each line with its connection and, where
// there is one, its request: `grep connection=7` is a client's whole story.
#pragma once

#include "server/operations/service_observer.hpp"

namespace multitetra {

// Connections, streams, estimates and meshes are told at level info, and so are requests over HTTP
// that are refused; the many small ones that are not (lists, tiles, files) at debug. A request over
// HTTP is named as its answer names it (X-Request-Id).
class RequestLog : public ServiceObserver {
 public:
  void connected(const ClientFacts& client) override;
  void disconnected(const ClientFacts& client, double seconds) override;
  void refused(const ClientFacts& client, const char* limit) override;
  void request_ended(const ClientFacts& client, const RequestFacts& facts) override;
  void error_answered(const ClientFacts& client, const Error& error,
                      std::uint64_t request) override;
  void http_answered(const ClientFacts& client, const HttpFacts& facts) override;
};

}  // namespace multitetra
