// Admission control for all listeners: connections, rate limits, tokens, draining.
//
//   auto admitted = admission.admit("tcp", address, peer);   // After accept().
//   if (!admitted.client) drop it;                           // Too many refused connections.
//   if (admitted.refusal) send it, then close;
//   if (const auto within = admitted.client->check_rate_limit(); !within) answer within.error();
//   RequestRecord record(admitted.client, {.kind = "stream", ...});  // Lives as long as the request.
//
// Holds what may change while the server runs: certificate, access list, draining.
//
// Not thread-safe. Must outlive its client contexts and records.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "server/operations/access_list.hpp"
#include "server/operations/byte_reservations.hpp"
#include "server/operations/client_address.hpp"
#include "server/operations/connection_limiter.hpp"
#include "server/operations/request_rate.hpp"
#include "server/operations/service_observer.hpp"
#include "server/operations/tls_files.hpp"

namespace multitetra {

struct AdmissionOptions {
  // Absent: plain TCP.
  std::optional<TlsFiles> tls = {};
  // The file of the access list. Absent: `access`; null: all datasets are public.
  std::optional<std::filesystem::path> tokens = {};
  AccessListPtr access = {};
  // The limits of concurrent connections, in total and per address.
  ConnectionLimits connections = {.total = 1024, .per_name = 256};
  // The rate limit of a token, or of an address without one.
  RequestRate requests = {.per_second = 200, .burst = 600};
  // The memory limit of everything that waits: requests for workers; steps, lists and HTTP answers
  // for their clients. One share (an address, a token) gets at most a quarter of what the others
  // leave.
  std::size_t queue_bytes = std::size_t{1} << 30;
  // Proxies whose X-Forwarded-For is trusted.
  AddressRanges trusted_proxies = {};
  // Null: events are not reported.
  ServiceObserverPtr observer = {};
};

class AdmissionControl;

// A connection that may be closed while idle, to admit a new one above the limit.
struct IdleConnection {
  using Clock = std::chrono::steady_clock;
  std::function<std::optional<Clock::time_point>()> since;  // nullopt while busy.
  std::function<void(const Error& why)> end;
};

// The state of one connection, from accept to close.
class ConnectionContext {
 public:
  ConnectionContext(AdmissionControl& admission, ClientFacts facts, std::string address,
                    ConnectionLimiter::Ticket ticket);
  ~ConnectionContext();
  ConnectionContext(const ConnectionContext&) = delete;
  ConnectionContext& operator=(const ConnectionContext&) = delete;

  [[nodiscard]] const ClientFacts& facts() const { return facts_; }
  [[nodiscard]] AdmissionControl& admission() const { return admission_; }

  // Applies the X-Forwarded-For values of a request, joined by commas. If the peer is a trusted
  // proxy, limits then apply to the forwarded client. Fails if that client has too many
  // connections.
  [[nodiscard]] Result<void> forwarded_for(std::string_view addresses);
  // Lets admission control close this connection while it is idle, to admit others.
  void set_evictable(IdleConnection how) { idle_ = std::move(how); }
  // Reports that the connection has changed its protocol.
  void set_protocol(ProtocolName protocol);
  // Sets the name for the log after the token check, and whether the client has its own token.
  void set_identity(std::string name, bool has_token) {
    facts_.name = std::move(name);
    has_token_ = has_token;
  }
  // Sets the client that a gateway forwards for, and its address for the log (may be empty).
  // Ignored unless the gateway is trusted.
  void set_forwarded_share(std::string name, std::string client_address);
  // Reports the accepted Hello. Call after set_protocol(), set_identity() and
  // set_forwarded_share().
  void record_welcome();
  // Names the client's share of time and memory: its token's, else its address's (IPv6: its /64
  // network's). For clients of a trusted gateway it is the share that the gateway names; behind a
  // trusted proxy without an address, the connection has its own share.
  [[nodiscard]] std::string quota_key() const;
  // Counts a request. Returns kLimitExceeded, with a retry delay, above the rate limit. Long
  // messages count for several requests, even if refused, because reading them costs time.
  [[nodiscard]] Result<void> check_rate_limit(std::size_t message_bytes = 0);
  // Reserves memory for waiting data, for the life of the result. Returns kUnavailable if there is
  // too little.
  [[nodiscard]] Result<ByteReservations::Reservation> reserve(std::size_t bytes);

 private:
  AdmissionControl& admission_;
  ClientFacts facts_;
  std::string address_;    // The peer's address, without port.
  std::string limit_key_;  // The name that limits apply to.
  bool has_token_ = false;
  // The share that a trusted gateway names; empty otherwise.
  std::string forwarded_share_;
  IdleConnection idle_;
  ConnectionLimiter::Ticket ticket_;
  std::chrono::steady_clock::time_point since_ = std::chrono::steady_clock::now();
  friend class AdmissionControl;
};
using ConnectionContextPtr = std::shared_ptr<ConnectionContext>;

class AdmissionControl {
 public:
  // Throws ExitError (kBadCredentials) if a file cannot be used.
  explicit AdmissionControl(AdmissionOptions options);
  AdmissionControl(const AdmissionControl&) = delete;
  AdmissionControl& operator=(const AdmissionControl&) = delete;

  struct AdmissionResult {
    ConnectionContextPtr client;  // Null: refused without a reply.
    // The error to send before closing.
    std::optional<Error> refusal;
  };
  [[nodiscard]] AdmissionResult admit(ProtocolName protocol, const std::string& address,
                                      const std::string& peer);

  // Returns the TLS context for the next connection; null for plain TCP.
  [[nodiscard]] const TlsContextPtr& tls() const { return tls_; }
  // Returns the access list; null if all datasets are public.
  [[nodiscard]] const AccessListPtr& access() const { return access_; }
  // Reloads certificate and tokens. If a file is invalid, logs that and keeps the previous one.
  void reload();

  // Refuses new work. Calls `when_idle` once, when no requests are in progress; possibly at once.
  void drain(std::function<void()> when_idle);
  [[nodiscard]] bool is_draining() const { return is_draining_; }
  // Returns kUnavailable while draining.
  [[nodiscard]] Result<void> check_draining() const;

  [[nodiscard]] ByteReservations& queue() { return queue_; }
  [[nodiscard]] ServiceObserver& observer() { return *observer_; }
  [[nodiscard]] std::size_t connections() const { return connections_.count(); }
  [[nodiscard]] std::size_t running_requests() const { return running_requests_; }
  [[nodiscard]] std::uint64_t requests() const { return requests_; }

 private:
  friend class ConnectionContext;
  friend class RequestRecord;
  void request_over();
  // Reports a connection above a limit.
  void report_excess(const ClientFacts& client);
  // Closes the longest idle connection of the address with the most connections, if that has more
  // than the new connection's address would have.
  void evict_idle_connection(const std::string& limit_key);

  AdmissionOptions options_;
  ServiceObserverPtr observer_;
  TlsContextPtr tls_;
  AccessListPtr access_;
  ConnectionLimiter connections_;
  ConnectionLimiter refused_;
  // Excludes refused connections.
  std::set<ConnectionContext*> clients_;
  RatePerName rates_;
  ByteReservations queue_;
  std::uint64_t last_connection_ = 0;
  std::size_t running_requests_ = 0;
  std::uint64_t requests_ = 0;
  bool is_draining_ = false;
  std::function<void()> when_idle_;
};

// A request in progress. Reports its facts to the observer when it ends.
class RequestRecord {
 public:
  RequestRecord(ConnectionContextPtr client, RequestFacts facts);
  // Ends the request as "left" unless it has ended.
  ~RequestRecord();
  RequestRecord(const RequestRecord&) = delete;
  RequestRecord& operator=(const RequestRecord&) = delete;

  // Sets the surface of the request, once known; `unit` is that of the error.
  void set_surface(double isovalue, double error, std::string_view unit);
  void sent_tile(std::size_t bytes);
  void sent_step() { ++facts_.steps; }
  void sent_body(std::size_t bytes) { facts_.bytes += bytes; }
  // Ends the request with an outcome as in RequestFacts. Only the first call has an effect.
  void end(std::string_view outcome);
  // Ends the request with an error reply, which the log and the metrics report with the request.
  void end(const Error& failure);
  [[nodiscard]] const RequestFacts& facts() const { return facts_; }

 private:
  [[nodiscard]] double seconds() const;

  ConnectionContextPtr client_;
  RequestFacts facts_;
  std::chrono::steady_clock::time_point since_ = std::chrono::steady_clock::now();
  bool has_ended_ = false;
};

}  // namespace multitetra
