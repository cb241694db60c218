#include "server/operations/admission_control.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include "common/base/number_text.hpp"
#include "server/operations/client_address.hpp"
#include "server/operations/log.hpp"

namespace multitetra {
namespace {

using Clock = std::chrono::steady_clock;

// Refused connections that linger to receive an error; further ones are dropped without a reply.
constexpr std::size_t kMaxRefusedAtOnce = 64;

// The part of the unreserved queue bytes that one share may reserve.
constexpr double kMaxShareFraction = 0.25;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

}  // namespace

// ---- clients

ConnectionContext::ConnectionContext(AdmissionControl& admission, ClientFacts facts,
                                     std::string address, ConnectionLimiter::Ticket ticket)
    : admission_(admission),
      facts_(std::move(facts)),
      address_(std::move(address)),
      limit_key_(admission.options_.trusted_proxies.contains(address_) ? "" : limit_key(address_)),
      ticket_(std::move(ticket)) {}

ConnectionContext::~ConnectionContext() {
  admission_.clients_.erase(this);
  try {
    admission_.observer().disconnected(facts_, seconds_since(since_));
  } catch (...) {  // A write error of the log must not end the server.
  }
}

void ConnectionContext::set_protocol(ProtocolName protocol) {
  admission_.observer().disconnected(facts_, seconds_since(since_));
  facts_.protocol = protocol;
  admission_.observer().connected(facts_);
}

Result<void> ConnectionContext::forwarded_for(std::string_view addresses) {
  const AddressRanges& trusted = admission_.options_.trusted_proxies;
  if (!trusted.contains(address_)) return {};
  ForwardedClient client = forwarded_client(address_, addresses, trusted);
  std::string limited = client.is_trusted ? "" : limit_key(client.address);
  if (limited == limit_key_) return {};
  ticket_ = {};  // Do not count this connection twice.
  auto ticket = limited.empty() ? admission_.connections_.acquire()
                                : admission_.connections_.acquire(limited);
  if (!ticket) {
    admission_.report_excess(facts_);
    return tl::unexpected(ticket.error());
  }
  ticket_ = *std::move(ticket);
  limit_key_ = std::move(limited);
  facts_.peer = std::move(client.address);
  return {};
}

void ConnectionContext::set_forwarded_share(std::string name, std::string client_address) {
  if (!admission_.options_.trusted_proxies.contains(address_)) return;
  forwarded_share_ = std::move(name);
  if (!client_address.empty()) facts_.peer = std::move(client_address);
}

void ConnectionContext::record_welcome() {
  facts_.is_welcomed = true;
  admission_.observer().welcomed(facts_);
}

std::string ConnectionContext::quota_key() const {
  if (!forwarded_share_.empty()) return "gateway " + address_ + " " + forwarded_share_;
  if (has_token_) return "token " + facts_.name;
  if (!limit_key_.empty()) return "address " + limit_key_;
  return "connection " + std::to_string(facts_.connection);
}

Result<void> ConnectionContext::check_rate_limit(std::size_t message_bytes) {
  constexpr std::size_t kBytesOfARequest = 64 * 1024;
  const double cost = 1 + static_cast<double>(message_bytes / kBytesOfARequest);
  const double now = std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
  if (limit_key_.empty()) return {};
  // The cost is divided by the number of shares that a network counts for.
  double wait = 0;
  for (const ShareLevel& level : share_levels(has_token_ ? quota_key() : limit_key_)) {
    wait = std::max(wait, admission_.rates_.take(level.name, now, cost / level.shares));
  }
  if (wait <= 0) return {};
  admission_.observer().refused(facts_, "requests_per_second");
  const double seconds = std::ceil(wait);
  return tl::unexpected(
      Error{.code = ErrorCode::kLimitExceeded,
            .text = "More than " + shortest_text(admission_.rates_.rate().per_second) +
                    " requests a second were received " +
                    (has_token_ ? "with your token" : "from your address") + "; retry after " +
                    (seconds == 1 ? "a second." : shortest_text(seconds) + " seconds."),
            .retry_after = wait});
}

Result<ByteReservations::Reservation> ConnectionContext::reserve(std::size_t bytes) {
  constexpr double kRetryAfter = 5;
  auto reservation = admission_.queue_.take(quota_key(), bytes);
  if (reservation) return *std::move(reservation);
  admission_.observer().refused(facts_, "queue_bytes");
  return tl::unexpected(
      Error{.code = ErrorCode::kUnavailable,
            .text = "This server does not have enough memory for that request now; retry in " +
                    shortest_text(kRetryAfter) + " s, or request a larger error.",
            .retry_after = kRetryAfter});
}

// ---- admission control

AdmissionControl::AdmissionControl(AdmissionOptions options)
    : options_(std::move(options)),
      observer_(options_.observer ? options_.observer : std::make_shared<ServiceObserver>()),
      tls_(options_.tls ? load_tls(*options_.tls) : nullptr),
      access_(options_.tokens ? load_access_list(*options_.tokens) : options_.access),
      connections_(options_.connections),
      refused_({.total = kMaxRefusedAtOnce}),
      rates_(options_.requests),
      queue_(options_.queue_bytes, kMaxShareFraction) {}

AdmissionControl::AdmissionResult AdmissionControl::admit(ProtocolName protocol,
                                                          const std::string& address,
                                                          const std::string& peer) {
  ClientFacts facts{.protocol = protocol, .connection = ++last_connection_, .peer = peer};
  // A trusted proxy serves many clients, whose addresses arrive with their requests.
  const bool is_proxy = options_.trusted_proxies.contains(address);
  const std::string name = is_proxy ? "" : limit_key(address);
  if (connections_.is_full()) evict_idle_connection(name);
  auto ticket = is_proxy ? connections_.acquire() : connections_.acquire(name);
  std::optional<Error> refusal;
  if (!ticket) {
    report_excess(facts);
    refusal = ticket.error();
    ticket = refused_.acquire();
    if (!ticket) return {};
  }
  observer_->connected(facts);
  auto client =
      std::make_shared<ConnectionContext>(*this, std::move(facts), address, *std::move(ticket));
  if (!refusal) clients_.insert(client.get());
  return {.client = std::move(client), .refusal = std::move(refusal)};
}

void AdmissionControl::report_excess(const ClientFacts& client) {
  observer_->refused(client, connections_.is_full() ? "connections" : "connections_per_address");
}

void AdmissionControl::evict_idle_connection(const std::string& limit_key) {
  const double newcomers = connections_.group_size_of(limit_key) + 1;
  ConnectionContext* longest = nullptr;
  double crowd = 0;
  IdleConnection::Clock::time_point since;
  for (ConnectionContext* const client : clients_) {
    const auto idle_since = client->idle_.since ? client->idle_.since() : std::nullopt;
    const double size = idle_since ? connections_.group_size_of(client->limit_key_) : 0;
    if (size <= newcomers || size < crowd) continue;
    if (size == crowd && *idle_since >= since) continue;
    longest = client;
    crowd = size;
    since = *idle_since;
  }
  if (longest == nullptr) return;
  observer_->refused(longest->facts_, "connections");
  longest->ticket_ = {};
  std::exchange(longest->idle_, {})
      .end({ErrorCode::kUnavailable,
            "The server closes its longest idle connection to accept new ones; connect again for "
            "the next request."});
}

void AdmissionControl::reload() {
  const auto attempt = [this](const char* what, const auto& load) {
    try {
      log_line(LogLevel::kInfo, std::string(what) + " reloaded", {{"tokens", load()}});
      observer_->reloaded(what, /*failed=*/false);
    } catch (const std::exception& failure) {
      log_line(LogLevel::kError,
               std::string(failure.what()) + " The previous " + what + " stays in use.", {});
      observer_->reloaded(what, /*failed=*/true);
    }
  };
  using Count = std::optional<LogValue>;
  if (options_.tls) {
    attempt("certificate", [this] {
      tls_ = load_tls(*options_.tls);
      return Count();
    });
  }
  if (options_.tokens) {
    attempt("tokens file", [this] {
      access_ = load_access_list(*options_.tokens);
      return Count(static_cast<std::uint64_t>(access_->size()));
    });
  }
}

void AdmissionControl::drain(std::function<void()> when_idle) {
  is_draining_ = true;
  when_idle_ = std::move(when_idle);
  if (running_requests_ == 0) std::exchange(when_idle_, nullptr)();
}

Result<void> AdmissionControl::check_draining() const {
  if (!is_draining_) return {};
  return fail(ErrorCode::kUnavailable,
              "The server is stopping and accepts no new requests; connect again later.");
}

void AdmissionControl::request_over() {
  --running_requests_;
  if (running_requests_ == 0 && when_idle_) std::exchange(when_idle_, nullptr)();
}

// ---- requests

RequestRecord::RequestRecord(ConnectionContextPtr client, RequestFacts facts)
    : client_(std::move(client)), facts_(std::move(facts)) {
  ++client_->admission().running_requests_;
  ++client_->admission().requests_;
  client_->admission().observer().request_began(client_->facts(), facts_.kind);
}

RequestRecord::~RequestRecord() {
  try {
    end("left");
  } catch (...) {  // See above.
  }
  client_->admission().request_over();
}

void RequestRecord::set_surface(double isovalue, double error, std::string_view unit) {
  facts_.isovalue = isovalue;
  facts_.error = error;
  facts_.unit = unit;
}

void RequestRecord::sent_tile(std::size_t bytes) {
  ++facts_.tiles;
  facts_.bytes += bytes;
  facts_.seconds_to_last_tile = seconds();
  if (!facts_.seconds_to_first_tile) facts_.seconds_to_first_tile = facts_.seconds_to_last_tile;
}

void RequestRecord::end(std::string_view outcome) {
  if (std::exchange(has_ended_, true)) return;
  facts_.outcome = outcome;
  facts_.seconds = seconds();
  client_->admission().observer().request_ended(client_->facts(), facts_);
}

void RequestRecord::end(const Error& failure) {
  if (!has_ended_) facts_.failure = failure;
  end(name(failure.code));
}

double RequestRecord::seconds() const { return seconds_since(since_); }

}  // namespace multitetra
