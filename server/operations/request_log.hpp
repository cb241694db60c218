// Writes what a service tells about its work into the log, each line with its connection and, where
// there is one, its request: `grep connection=7` is a client's whole story.
#pragma once

#include "server/operations/service_observer.hpp"

namespace multitetra {

// Connections, streams, estimates and meshes are told at level info; the many small requests of
// HTTP (lists, tiles, files) at debug.
class RequestLog : public ServiceObserver {
 public:
  void connected(const ClientFacts& client) override;
  void disconnected(const ClientFacts& client, double seconds) override;
  void refused(const ClientFacts& client, const char* limit) override;
  void request_ended(const ClientFacts& client, const RequestFacts& facts) override;
  void error_answered(const ClientFacts& client, const Error& error,
                      std::uint64_t request) override;
};

}  // namespace multitetra
