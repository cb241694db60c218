// Writes the events of a service into the log, each line with its connection and, where there is
// one, its request: `grep connection=7` selects everything of one client.
#pragma once

#include "server/operations/service_observer.hpp"

namespace multitetra {

// Connections, streams, estimates and meshes are logged at level info, and so are refused HTTP
// requests; the many small ones that succeed (lists, tiles, files) at debug. An HTTP request has
// the name that its response has (X-Request-Id), and a rejected one a single line, with its reason.
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
