// Logs the events of a service. Each line has its connection and, if any, its request: `grep
// connection=7` finds all lines of one connection.
#pragma once

#include "server/operations/service_observer.hpp"

namespace multitetra {

// Every request about datasets, including a rejected one, and every connection is one line at level
// info (HTTP connections: debug). Successful requests for tiles by digest, viewer files, health
// checks and metrics are at debug. Server failures and lack of capacity are warnings. HTTP requests
// have the id of their response (X-Request-Id), and rejected ones the reason.
class RequestLog : public ServiceObserver {
 public:
  void connected(const ClientFacts& client) override;
  void welcomed(const ClientFacts& client) override;
  void disconnected(const ClientFacts& client, double seconds) override;
  void refused(const ClientFacts& client, const char* limit) override;
  void request_ended(const ClientFacts& client, const RequestFacts& facts) override;
  void error_answered(const ClientFacts& client, const Error& error,
                      std::uint64_t request) override;
  void http_answered(const ClientFacts& client, const HttpFacts& facts) override;
};

}  // namespace multitetra
