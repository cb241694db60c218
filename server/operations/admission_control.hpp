// Admission control shared by all listeners: connections, rate limits, tokens, draining.
//
//   auto admitted = admission.admit("tcp", address, peer);   // A connection was accepted.
//   if (!admitted.client) drop it;                         // Too many of those that are refused.
//   if (admitted.refusal) send it, then close;
//   if (const auto asked = admitted.client->check_rate_limit(); !asked) answer asked.error();
//   RequestRecord record(admitted.client, {.kind = "stream", ...});  // Lives as long as the request.
//
// It holds what may change while the server runs: certificate, access list, whether it drains.
//
// One thread at a time. Client contexts and records must not outlive the admission.
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
  std::optional<TlsFiles> tls = {};                  // None: plain TCP.
  std::optional<std::filesystem::path> tokens = {};  // None: everybody may see everything.
  ConnectionLimits connections = {.total = 1024, .per_name = 256};  // Names are addresses.
  // The rate limit of a token, or of an address without one.
  RequestRate requests = {.per_second = 200, .burst = 600};
  // The bytes of everything that waits: requests for workers, steps, lists and HTTP answers for
  // their clients. One share (an address, a token) has at most a quarter of what the others leave.
  std::size_t queue_bytes = std::size_t{1} << 30;
  // Proxies whose X-Forwarded-For is trusted.
  AddressRanges trusted_proxies = {};
  // May be null: no events are reported.
  ServiceObserverPtr observer = {};
};

class AdmissionControl;

// An idle connection, which is closed when a new one exceeds the limit.
struct IdleConnection {
  using Clock = std::chrono::steady_clock;
  std::function<std::optional<Clock::time_point>()> since;  // nullopt while it has something to do.
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

  // The values of X-Forwarded-For of a request, joined by commas. If a trusted proxy says so,
  // limits then apply to the forwarded client. An error when there are too many connections
  // from there.
  [[nodiscard]] Result<void> forwarded_for(std::string_view addresses);
  // When there are too many connections, this one may be closed while it is idle.
  void set_evictable(IdleConnection how) { resting_ = std::move(how); }
  // Its connection is of another kind from now on.
  void changes_to(ProtocolName protocol);
  // After its token was accepted: the name for the log, and whether it is that of its own token.
  void is_named(std::string name, bool has_token) {
    facts_.name = std::move(name);
    has_token_ = has_token;
  }
  // The client that a gateway names, and its address for the log (empty: not given); accepted from
  // trusted gateways only.
  void asks_for(std::string name, std::string client_address);
  // Whose share of the server's time and memory this client has: that of its token, else that of
  // its address (IPv6: its /64 network). Whom a trusted proxy or gateway brings has the share
  // that it names, or else one of its own.
  [[nodiscard]] std::string share() const;
  // Counts a request. kLimitExceeded when there were too many within a short time; it says when to
  // come again. Long messages count for several, also where they are refused: to read them costs
  // time.
  [[nodiscard]] Result<void> check_rate_limit(std::size_t message_bytes = 0);
  // Room for what waits, as long as the reservation lives. kUnavailable when there is none.
  [[nodiscard]] Result<ByteReservations::Reservation> reserve(std::size_t bytes);

 private:
  AdmissionControl& admission_;
  ClientFacts facts_;
  std::string address_;  // Without port, of the connection itself.
  std::string limited_;  // The name under which limits count.
  bool has_token_ = false;
  std::string asks_for_;
  IdleConnection resting_;
  ConnectionLimiter::Ticket ticket_;
  std::chrono::steady_clock::time_point since_ = std::chrono::steady_clock::now();
  friend class AdmissionControl;
};
using ConnectionContextPtr = std::shared_ptr<ConnectionContext>;

class AdmissionControl {
 public:
  // Throws ExitError (kNoSecrets) when a file cannot be used.
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

  // For the next connection; null for plain TCP.
  [[nodiscard]] const TlsContextPtr& tls() const { return tls_; }
  // Null where everybody may see everything.
  [[nodiscard]] const AccessListPtr& access() const { return access_; }
  // Reads certificate and tokens again. What cannot be used is logged, and the old one stays.
  void reload();

  // From now on new work is refused; `when_idle` is called once, when no request is under way:
  // maybe now.
  void drain(std::function<void()> when_idle);
  [[nodiscard]] bool is_draining() const { return is_draining_; }
  // kUnavailable while it drains.
  [[nodiscard]] Result<void> may_begin_work() const;

  [[nodiscard]] ByteReservations& queue() { return queue_; }
  [[nodiscard]] ServiceObserver& observer() { return *observer_; }
  [[nodiscard]] std::size_t connections() const { return connections_.inside(); }
  [[nodiscard]] std::size_t running_requests() const { return running_requests_; }
  [[nodiscard]] std::uint64_t requests() const { return requests_; }  // Requests that began so far.

 private:
  friend class ConnectionContext;
  friend class RequestRecord;
  void request_over();
  // Closes the longest idle connection of the address with the most idle connections, if that has
  // more than the newcomer's address would have.
  void make_room_for(const std::string& limited_name);

  AdmissionOptions options_;
  ServiceObserverPtr observer_;
  TlsContextPtr tls_;
  AccessListPtr access_;
  ConnectionLimiter connections_;
  // Connections that are being refused.
  ConnectionLimiter refused_;
  std::set<ConnectionContext*> clients_;  // Those that were not refused.
  RatePerName rates_;
  ByteReservations queue_;
  std::uint64_t last_connection_ = 0;
  std::size_t running_requests_ = 0;
  std::uint64_t requests_ = 0;
  bool is_draining_ = false;
  std::function<void()> when_idle_;
};

// A request in progress. Its facts are reported to the observer when it ends.
class RequestRecord {
 public:
  RequestRecord(ConnectionContextPtr client, RequestFacts facts);
  // A request that did not end was left by its client.
  ~RequestRecord();
  RequestRecord(const RequestRecord&) = delete;
  RequestRecord& operator=(const RequestRecord&) = delete;

  // The surface that it is about, once that is known; the unit is that of the error.
  void is_about(double isovalue, double error, std::string_view unit);
  void sent_tile(std::size_t bytes);
  void sent_step() { ++facts_.steps; }
  // The outcome as in RequestFacts. Only the first end counts.
  void end(std::string_view outcome);
  [[nodiscard]] const RequestFacts& facts() const { return facts_; }

 private:
  [[nodiscard]] double seconds() const;

  ConnectionContextPtr client_;
  RequestFacts facts_;
  std::chrono::steady_clock::time_point since_ = std::chrono::steady_clock::now();
  bool has_ended_ = false;
};

}  // namespace multitetra
