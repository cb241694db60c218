// The events of a service, for metrics and log. Sessions depend on this interface only.
//
// Events that are not overridden are ignored. All calls come from the thread of input and output,
// and must be quick.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/result.hpp"

namespace multitetra {

// The transport of a client: "tcp", "websocket", "http". Always a literal.
using ProtocolName = const char*;

// The client as the log names it.
struct ClientFacts {
  ProtocolName protocol = "tcp";
  std::uint64_t connection = 0;  // A number that no other connection of this process has.
  std::string peer = {};         // Address and port.
  std::string name = {};         // The name of the token; empty without.
};

// A request that was answered, or was not.
struct RequestFacts {
  const char* kind = "stream";  // "stream", "estimate", "list"; of HTTP: "isosurface", "tile", ...
  std::uint64_t request = 0;    // The client's request id.
  // Over HTTP: the X-Request-Id; empty otherwise.
  std::string id = {};
  std::string dataset = {};
  std::optional<double> isovalue = {};
  std::optional<double> error = {};
  // The unit of `error`: "voxel" or "world".
  std::string_view unit = {};
  std::uint32_t steps = 0;  // Whole ones.
  std::uint64_t tiles = 0;
  // Bytes of tiles, or of the mesh.
  std::uint64_t bytes = 0;
  std::optional<double> seconds_to_first_tile = {};  // From the request on.
  std::optional<double> seconds_to_last_tile = {};
  double seconds = 0;  // Until it ended.
  // "complete", "cancelled", "superseded", "left" (the client has gone), or the name of an
  // ErrorCode.
  std::string_view outcome = "complete";
};

// An HTTP request and its outcome.
struct HttpFacts {
  std::string_view id = {};  // The X-Request-Id.
  // The kind of request: "isosurface", "tile", "viewer", ..., "refused" where it was not examined,
  // and "malformed"; always a literal.
  const char* kind = "malformed";
  std::string_view method = {};
  std::string_view target = {};
  int status = 0;
  // The size of the body.
  std::uint64_t bytes = 0;
  double seconds = 0;  // Until its last byte was on its way.
  // Of an error, for the log alone: it may say more than the client is answered. Empty without.
  std::string_view reason = {};
};

class ServiceObserver {
 public:
  virtual ~ServiceObserver() = default;

  virtual void connected(const ClientFacts&) {}
  // Every connection that was reported by connected() ends so, once.
  virtual void disconnected(const ClientFacts&, double /*seconds*/) {}
  // A client was refused; `limit` is a literal, such as "connections".
  virtual void refused(const ClientFacts&, const char* /*limit*/) {}
  // A request's work begins; request_ended() follows.
  virtual void request_began(const ClientFacts&, const char* /*kind*/) {}
  virtual void request_ended(const ClientFacts&, const RequestFacts&) {}
  // An answer that is an error, of a request (by its id) or of the connection (0).
  virtual void error_answered(const ClientFacts&, const Error&, std::uint64_t /*request*/) {}
  virtual void http_answered(const ClientFacts&, const HttpFacts&) {}
  virtual void step_made(double /*seconds*/) {}  // By a worker.
  virtual void sent(ProtocolName, std::size_t /*bytes*/) {}
};

using ServiceObserverPtr = std::shared_ptr<ServiceObserver>;

// Notifies several observers.
class ServiceObservers : public ServiceObserver {
 public:
  explicit ServiceObservers(std::vector<ServiceObserverPtr> all) : all_(std::move(all)) {}

  void connected(const ClientFacts& client) override {
    for (const auto& one : all_) one->connected(client);
  }
  void disconnected(const ClientFacts& client, double seconds) override {
    for (const auto& one : all_) one->disconnected(client, seconds);
  }
  void refused(const ClientFacts& client, const char* limit) override {
    for (const auto& one : all_) one->refused(client, limit);
  }
  void request_began(const ClientFacts& client, const char* kind) override {
    for (const auto& one : all_) one->request_began(client, kind);
  }
  void request_ended(const ClientFacts& client, const RequestFacts& facts) override {
    for (const auto& one : all_) one->request_ended(client, facts);
  }
  void error_answered(const ClientFacts& client, const Error& error,
                      std::uint64_t request) override {
    for (const auto& one : all_) one->error_answered(client, error, request);
  }
  void http_answered(const ClientFacts& client, const HttpFacts& facts) override {
    for (const auto& one : all_) one->http_answered(client, facts);
  }
  void step_made(double seconds) override {
    for (const auto& one : all_) one->step_made(seconds);
  }
  void sent(ProtocolName protocol, std::size_t bytes) override {
    for (const auto& one : all_) one->sent(protocol, bytes);
  }

 private:
  std::vector<ServiceObserverPtr> all_;
};

}  // namespace multitetra
