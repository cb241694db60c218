// The events of a service, for metrics and log. Sessions depend only on this interface.
//
// Events that are not overridden are ignored. All calls are made on the I/O thread, and must return
// quickly.
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

// A client's transport: "tcp", "websocket" or "http". Always a string literal.
using ProtocolName = const char*;

// Identifies a client in the log.
struct ClientFacts {
  ProtocolName protocol = "tcp";
  std::uint64_t connection = 0;  // Unique within the process.
  std::string peer = {};         // Address and port.
  std::string name = {};         // The token's name; empty without a token.
  // Whether its Hello was accepted; health probes send none.
  bool is_welcomed = false;
};

// A finished request and its outcome.
struct RequestFacts {
  const char* kind = "stream";  // "estimate", "list"; over HTTP "isosurface", "tile", ...
  std::uint64_t request = 0;    // The client's request id.
  // Over HTTP: the X-Request-Id; empty otherwise.
  std::string id = {};
  std::string dataset = {};
  std::optional<double> isovalue = {};
  std::optional<double> error = {};
  // The unit of `error`: "voxel" or "world".
  std::string_view unit = {};
  std::uint32_t steps = 0;  // Complete steps.
  std::uint64_t tiles = 0;
  // Bytes of tiles, or of the mesh.
  std::uint64_t bytes = 0;
  std::optional<double> seconds_to_first_tile = {};  // Since the request.
  std::optional<double> seconds_to_last_tile = {};
  double seconds = 0;
  // "complete", "cancelled", "superseded", "left" (the client has disconnected), or the name of an
  // ErrorCode.
  std::string_view outcome = "complete";
  // Over TCP and WebSocket: the error reply that ended the request; `outcome` is the name of its
  // code.
  std::optional<Error> failure = {};
};

// An HTTP request and its outcome.
struct HttpFacts {
  std::string_view id = {};  // The X-Request-Id.
  // The X-Request-Id of the request, set by a proxy.
  std::string_view proxy_id = {};
  // A string literal: "isosurface", "tile", "viewer", ..., "redirect", "refused" if not examined,
  // "malformed".
  const char* kind = "malformed";
  std::string_view method = {};
  std::string_view target = {};
  std::string_view dataset = {};
  int status = 0;
  // The size of the body.
  std::uint64_t bytes = 0;
  double seconds = 0;  // Time until the last byte was sent.
  // The name of an error's code; otherwise "complete".
  std::string_view outcome = "complete";
  // The reason of an error, for the log only; it may contain more than the reply. Otherwise empty.
  std::string_view reason = {};
};

class ServiceObserver {
 public:
  virtual ~ServiceObserver() = default;

  virtual void connected(const ClientFacts&) {}
  // Reports that a client's Hello was accepted.
  virtual void welcomed(const ClientFacts&) {}
  // Called exactly once for each connected().
  virtual void disconnected(const ClientFacts&, double /*seconds*/) {}
  // Reports a refused client; `limit` is a string literal, such as "connections".
  virtual void refused(const ClientFacts&, const char* /*limit*/) {}
  // Reports the start of a request; request_ended() follows.
  virtual void request_began(const ClientFacts&, const char* /*kind*/) {}
  virtual void request_ended(const ClientFacts&, const RequestFacts&) {}
  // Reports an error sent for a request (by id) or for the connection (0). A failure in
  // RequestFacts is not reported again.
  virtual void error_answered(const ClientFacts&, const Error&, std::uint64_t /*request*/) {}
  virtual void http_answered(const ClientFacts&, const HttpFacts&) {}
  virtual void step_made(double /*seconds*/) {}
  // Reports that something was loaded, a string literal such as "certificate", and whether that
  // failed, for datasets also in part.
  virtual void reloaded(const char* /*what*/, bool /*failed*/) {}
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
  void welcomed(const ClientFacts& client) override {
    for (const auto& one : all_) one->welcomed(client);
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
  void reloaded(const char* what, bool failed) override {
    for (const auto& one : all_) one->reloaded(what, failed);
  }
  void sent(ProtocolName protocol, std::size_t bytes) override {
    for (const auto& one : all_) one->sent(protocol, bytes);
  }

 private:
  std::vector<ServiceObserverPtr> all_;
};

}  // namespace multitetra
