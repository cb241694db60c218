// Writes the events of a service into the log, each line with its connection and, where there is
// one, its request: `grep connection=7` selects everything of one client.
#pragma once

#include "server/operations/service_observer.hpp"

namespace multitetra {

// Every request about datasets is one line at level info, also a rejected one, and so is a
// connection (HTTP: at debug). Tiles by digest, files of the viewer, health checks and metrics are
// at debug when they succeed. Warnings are what the server has no capacity for, and its failures.
// An HTTP request has the name that its response has (X-Request-Id), and a rejected one its reason.
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
