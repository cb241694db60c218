#include "server/operations/doorkeeper.hpp"

#include <exception>
#include <utility>

#include "common/number_text.hpp"
#include "server/operations/client_address.hpp"
#include "server/operations/log.hpp"

namespace multitetra {
namespace {

using Clock = std::chrono::steady_clock;

// Refused connections linger for a moment; beyond so many they are dropped without a word.
constexpr std::size_t kMostRefusedAtOnce = 64;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

}  // namespace

// ---- guests

Guest::Guest(Doorkeeper& keeper, ClientFacts facts, std::string address, Admissions::Ticket ticket)
    : keeper_(keeper),
      facts_(std::move(facts)),
      address_(std::move(address)),
      limited_(is_among(address_, keeper.options_.trusted_proxies) ? "" : limited_name(address_)),
      ticket_(std::move(ticket)) {}

Guest::~Guest() {
  try {
    keeper_.observer().disconnected(facts_, seconds_since(since_));
  } catch (...) {  // A log that cannot be written takes nobody else down.
  }
}

void Guest::changes_to(DoorName door) {
  keeper_.observer().disconnected(facts_, seconds_since(since_));
  facts_.door = door;
  keeper_.observer().connected(facts_);
}

std::optional<Error> Guest::forwarded_for(std::string_view addresses) {
  const std::vector<std::string>& trusted = keeper_.options_.trusted_proxies;
  if (!is_among(address_, trusted)) return std::nullopt;
  const std::string client = client_behind(address_, addresses, trusted);
  std::string limited = is_among(client, trusted) ? "" : limited_name(client);
  if (limited == limited_) return std::nullopt;
  ticket_ = {};  // The same connection is not counted twice.
  auto ticket = limited.empty() ? keeper_.admissions_.enter() : keeper_.admissions_.enter(limited);
  if (!ticket) {
    keeper_.observer().refused(facts_, "connections");
    return ticket.error();
  }
  ticket_ = *std::move(ticket);
  limited_ = std::move(limited);
  facts_.peer = client;
  return std::nullopt;
}

std::optional<Error> Guest::may_ask() {
  const double now = std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
  if (limited_.empty() || keeper_.rates_.take(limited_, now)) return std::nullopt;
  keeper_.observer().refused(facts_, "requests_per_second");
  return Error{ErrorCode::kLimitExceeded,
               "More than " + shortest_text(keeper_.rates_.rate().per_second) +
                   " requests a second came from your address; wait a second."};
}

std::optional<Error> Guest::may_ask_in_conversation() {
  if (std::string_view(facts_.door) == "http") return std::nullopt;
  return may_ask();
}

// ---- the keeper

Doorkeeper::Doorkeeper(DoorkeeperOptions options)
    : options_(std::move(options)),
      observer_(options_.observer ? options_.observer : std::make_shared<ServiceObserver>()),
      tls_(options_.tls ? load_tls(*options_.tls) : nullptr),
      access_(options_.tokens ? load_access_list(*options_.tokens) : nullptr),
      admissions_(options_.connections),
      refused_({.total = kMostRefusedAtOnce}),
      rates_(options_.requests),
      queue_(options_.queue_bytes) {}

Doorkeeper::Admitted Doorkeeper::admit(DoorName door, const std::string& address,
                                       const std::string& peer) {
  ClientFacts facts{.door = door, .connection = ++last_connection_, .peer = peer};
  // A trusted proxy brings many; who they are is known when they ask.
  const bool is_proxy = is_among(address, options_.trusted_proxies);
  auto ticket = is_proxy ? admissions_.enter() : admissions_.enter(limited_name(address));
  std::optional<Error> refusal;
  if (!ticket) {
    observer_->refused(facts, "connections");
    refusal = ticket.error();
    ticket = refused_.enter();
    if (!ticket) return {};
  }
  observer_->connected(facts);
  return {.guest = std::make_shared<Guest>(*this, std::move(facts), address, *std::move(ticket)),
          .refusal = std::move(refusal)};
}

void Doorkeeper::reload() {
  const auto attempt = [](const char* what, const auto& load) {
    try {
      load();
      log_line(LogLevel::kInfo, std::string(what) + " read again", {});
    } catch (const std::exception& trouble) {
      log_line(LogLevel::kError,
               std::string(trouble.what()) + " The " + what + " of before stays in use.", {});
    }
  };
  if (options_.tls) attempt("certificate", [this] { tls_ = load_tls(*options_.tls); });
  if (options_.tokens)
    attempt("tokens file", [this] { access_ = load_access_list(*options_.tokens); });
}

void Doorkeeper::drain(std::function<void()> when_idle) {
  is_draining_ = true;
  when_idle_ = std::move(when_idle);
  if (running_requests_ == 0) std::exchange(when_idle_, nullptr)();
}

std::optional<Error> Doorkeeper::refusal_of_work() const {
  if (!is_draining_) return std::nullopt;
  return Error{ErrorCode::kUnavailable,
               "The server is about to stop and begins nothing new; connect again later."};
}

void Doorkeeper::request_over() {
  --running_requests_;
  if (running_requests_ == 0 && when_idle_) std::exchange(when_idle_, nullptr)();
}

// ---- requests

RequestRecord::RequestRecord(GuestPtr guest, RequestFacts facts)
    : guest_(std::move(guest)), facts_(std::move(facts)) {
  ++guest_->keeper().running_requests_;
  guest_->keeper().observer().request_began(guest_->facts(), facts_.kind);
}

RequestRecord::~RequestRecord() {
  try {
    end("left");
  } catch (...) {  // As above.
  }
  guest_->keeper().request_over();
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
  guest_->keeper().observer().request_ended(guest_->facts(), facts_);
}

double RequestRecord::seconds() const { return seconds_since(since_); }

}  // namespace multitetra
