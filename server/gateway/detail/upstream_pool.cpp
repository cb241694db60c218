#include "server/gateway/detail/upstream_pool.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <utility>

#include "common/net/coroutines.hpp"
#include "server/gateway/detail/rendezvous.hpp"
#include "server/operations/log.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kMaxOffers = 256;
constexpr const char* kNoUpstream =
    "No server behind this gateway can be reached now; try again later.";

asio::awaitable<void> pause(asio::any_io_executor executor, std::chrono::milliseconds time) {
  asio::steady_timer timer(executor, time);
  co_await wait_on(timer);
}

}  // namespace

EncodedStep UpstreamDataset::make(const StepRequest&, std::stop_token) const {
  throw std::logic_error("A gateway makes no steps.");
}
SizeEstimates UpstreamDataset::sizes(std::stop_token, SizeAccuracy) const {
  throw std::logic_error("A gateway measures no steps.");
}

UpstreamPool::UpstreamPool(asio::any_io_executor executor, UpstreamOptions options)
    : executor_(executor), options_(std::move(options)), tiles_(options_.tile_bytes) {
  for (const Endpoint& upstream : options_.upstreams) {
    upstreams_.push_back({.name = to_string(upstream),
                          .health = UpstreamHealth(options_.min_backoff, options_.max_backoff),
                          .timer = std::make_unique<asio::steady_timer>(executor)});
  }
}

// ---- servers

void UpstreamPool::record_attempt(std::size_t upstream, bool is_reached, const std::string& why) {
  Upstream& one = upstreams_[upstream];
  using Change = UpstreamHealth::Change;
  const Change change =
      is_reached ? one.health.record_success() : one.health.record_failure(Clock::now());
  if (!is_reached) {
    catalogues_.clear();
    // The monitoring link may not have noticed yet; monitor() makes another one.
    if (one.watched) one.watched->close();
  }
  if (change == Change::kLost) {
    log_line(LogLevel::kWarning, "upstream unreachable", {{"upstream", one.name}, {"why", why}});
  } else if (change == Change::kReachable) {
    log_line(LogLevel::kInfo, "upstream reachable", {{"upstream", one.name}});
  }
}

void UpstreamPool::report_lost(std::size_t upstream) {
  record_attempt(upstream, false, "it closed the connection or is stopping");
}

void UpstreamPool::report_lost_stream(std::size_t upstream, std::uint64_t connection,
                                      std::uint64_t request) {
  Upstream& one = upstreams_[upstream];
  ++one.lost_streams;
  const std::string id = std::to_string(request);
  log_line(LogLevel::kWarning, "upstream lost in a stream; trying another upstream",
           {{"connection", connection}, {"request", id}, {"upstream", one.name}});
  report_lost(upstream);
}

void UpstreamPool::sent_damaged_tile(std::size_t upstream, const std::string& why) {
  Upstream& one = upstreams_[upstream];
  ++one.damaged_tiles;
  catalogues_.clear();
  if (one.health.quarantine(Clock::now(), options_.quarantine_time) !=
      UpstreamHealth::Change::kLost)
    return;
  const auto seconds =
      std::chrono::duration_cast<std::chrono::seconds>(options_.quarantine_time).count();
  log_line(LogLevel::kError,
           "a server sends damaged tiles and is not used for " + std::to_string(seconds) + " s",
           {{"upstream", one.name}, {"why", why}});
}

bool UpstreamPool::is_ready() const {
  return std::any_of(upstreams_.begin(), upstreams_.end(),
                     [](const Upstream& one) { return one.health.is_reachable(Clock::now()); });
}

std::vector<UpstreamState> UpstreamPool::upstreams() const {
  std::vector<UpstreamState> all;
  for (const Upstream& one : upstreams_) {
    all.push_back({.name = one.name,
                   .is_up = one.health.is_reachable(Clock::now()),
                   .damaged_tiles = one.damaged_tiles,
                   .lost_streams = one.lost_streams});
  }
  return all;
}

std::string UpstreamPool::token_for_upstream(const std::string& token) const {
  return options_.secrets.token.value_or(token);
}

LinkOptions UpstreamPool::link_options() const {
  return {.tls = options_.secrets.tls,
          .connect_timeout = options_.connect_timeout,
          .silence_timeout = options_.silence_timeout};
}

// A server that refuses the client still counts as reachable.
asio::awaitable<Result<LinkPtr>> UpstreamPool::link_to(std::size_t upstream,
                                                       UpstreamClient client) {
  Hello hello{.token = token_for_upstream(client.token),
              .agent = "multitetra-gateway/" MULTITETRA_VERSION,
              .on_behalf_of = client.share,
              .client_address = client.address};
  if (client.shells) hello.codecs.push_back(PayloadCodec::kSampleShell);
  LinkOptions options = link_options();
  auto link = co_await UpstreamLink::connect(executor_, options_.upstreams[upstream],
                                             std::move(hello), std::move(options));
  // If the gateway's own token is refused, clients get a general error.
  const bool is_ours = options_.secrets.token.has_value();
  const bool is_reachable = link || (link.error().code != ErrorCode::kUnavailable && !is_ours);
  record_attempt(upstream, is_reachable, is_reachable ? "" : link.error().text);
  // Addresses and reasons are for the log only.
  if (!is_reachable) co_return fail(ErrorCode::kUnavailable, kNoUpstream);
  if (link && is_stopped_) (*link)->close();
  co_return link;
}

void UpstreamPool::monitor_upstreams() {
  for (std::size_t i = 0; i < upstreams_.size(); ++i) {
    spawn(executor_, [this, i] { return monitor(i); });
  }
}

// Returns whether the server is alive and may accept a link without a client's token. Records the
// attempt unless such a link follows.
asio::awaitable<bool> UpstreamPool::ping(std::size_t upstream) {
  LinkOptions options = link_options();
  const auto alive =
      co_await UpstreamLink::ping(executor_, options_.upstreams[upstream], std::move(options));
  const bool may_connect = alive && !alive->requires_token && !upstreams_[upstream].requires_token;
  if (!may_connect) record_attempt(upstream, alive.has_value(), alive ? "" : alive.error().text);
  co_return may_connect;
}

// Reconnects after a pause, or when the server may be retried. A server that requires a client's
// token is only pinged, after each silence.
asio::awaitable<void> UpstreamPool::monitor(std::size_t upstream) {
  Upstream& one = upstreams_[upstream];
  while (!is_stopped_) {
    Clock::time_point next = Clock::now() + options_.silence_timeout;
    bool may_connect = options_.secrets.token && !one.requires_token;
    if (!may_connect) may_connect = co_await ping(upstream);
    if (may_connect) {
      const UpstreamClient no_client;  // A named variable, for the reason given below.
      const auto link = co_await link_to(upstream, no_client);
      one.requires_token = !link && link.error().code == ErrorCode::kUnauthenticated;
      if (link && options_.warns_of_open_servers && !std::exchange(one.is_known_open, true)) {
        log_line(LogLevel::kWarning,
                 "other machines can connect, and every client may see all datasets of a server "
                 "that requires no token: set --tokens to restrict that",
                 {{"upstream", one.name}});
      }
      if (link) {
        one.watched = *link;
        Result<ServerMessage> sign = co_await one.watched->receive();
        while (sign) sign = co_await one.watched->receive();
        one.watched.reset();
        next = Clock::now() + options_.min_backoff;
      }
    }
    if (one.health.has_failed()) next = one.health.next_try();
    if (is_stopped_) co_return;
    one.timer->expires_at(next);
    co_await wait_on(*one.timer);
  }
}

void UpstreamPool::stop() {
  is_stopped_ = true;
  for (Upstream& one : upstreams_) {
    one.timer->cancel();
    if (one.watched) one.watched->close();
  }
}

void UpstreamPool::use(UpstreamSecrets secrets) {
  options_.secrets = std::move(secrets);
  for (Upstream& one : upstreams_) one.requires_token = false;
  catalogues_.clear();
}

// ---- listing datasets

asio::awaitable<Result<UpstreamPool::Listing>> UpstreamPool::list_of(std::size_t upstream,
                                                                     std::string token) {
  // Made before it is awaited: GCC 12 destroys an aggregate of an awaiting expression twice.
  UpstreamClient client{.token = std::move(token), .shells = true};
  const auto link = co_await link_to(upstream, std::move(client));
  if (!link) co_return tl::unexpected(link.error());
  Listing listing{.datasets = {}, .shells = (*link)->sends_shells()};
  ListDatasets request{.request_id = 1, .in_pages = true};
  do {
    (*link)->send(request);
    auto answer = co_await (*link)->receive();
    auto* page = answer ? std::get_if<DatasetList>(&*answer) : nullptr;
    if (!page || !continues_list(*page, listing.datasets)) {
      (*link)->close();
      if (!answer) co_return tl::unexpected(answer.error());
      if (const auto* error = std::get_if<ErrorReply>(&*answer)) {
        co_return tl::unexpected(error->error);
      }
      co_return fail(ErrorCode::kInternal, "A server did not send its list of datasets.");
    }
    listing.datasets.insert(listing.datasets.end(), std::make_move_iterator(page->datasets.begin()),
                            std::make_move_iterator(page->datasets.end()));
    request.after = std::move(page->next);
  } while (!request.after.empty());
  (*link)->close();
  co_return listing;
}

asio::awaitable<Result<CataloguePtr>> UpstreamPool::catalogue(std::string token) {
  const std::string key = token_for_upstream(token);
  if (const auto known = catalogues_.find(key);
      known != catalogues_.end() && Clock::now() - known->second.at < options_.list_lifetime) {
    co_return known->second.catalogue;
  }
  if (const auto found = pending_listings_.find(key); found != pending_listings_.end()) {
    const std::shared_ptr<PendingListing> listing = found->second;
    while (!listing->result) co_await listing->done.wait();
    co_return *listing->result;
  }
  const auto listing = std::make_shared<PendingListing>(executor_);
  pending_listings_[key] = listing;
  try {
    listing->result = co_await list_all(key);
  } catch (const std::exception& error) {
    listing->result = fail(ErrorCode::kInternal, "The gateway failed to list the datasets.");
    log_line(LogLevel::kError, std::string("listing failed: ") + error.what(), {});
  }
  pending_listings_.erase(key);
  listing->done.notify_all();
  const Result<CataloguePtr>& found = *listing->result;
  if (found) {
    datasets_ = (*found)->size();
    if (catalogues_.size() >= kMaxOffers) catalogues_.clear();
    catalogues_[key] = {.at = Clock::now(), .catalogue = *found};
  }
  co_return found;
}

asio::awaitable<Result<CataloguePtr>> UpstreamPool::list_all(std::string token) {
  std::map<std::string, std::shared_ptr<UpstreamDataset>> merged;
  std::optional<Error> failure;
  bool has_list = false;
  // Servers that failed recently come last, and are skipped if another one has answered.
  for (const bool is_late : {false, true}) {
    for (std::size_t i = 0; i < upstreams_.size(); ++i) {
      if (upstreams_[i].health.has_failed() != is_late || (is_late && has_list)) continue;
      auto list = co_await list_of(i, token);
      if (!list) {
        if (!failure || failure->code == ErrorCode::kUnavailable) failure = list.error();
        continue;
      }
      has_list = true;
      for (DatasetInfo& info : list->datasets) {
        auto& dataset = merged[info.name];
        if (!dataset) dataset = std::make_shared<UpstreamDataset>(info);
        if (dataset->info() == info) {
          dataset->replicas.push_back(i);
          dataset->shells = dataset->shells && list->shells;
        } else {
          log_line(LogLevel::kWarning,
                   "two servers have different datasets of this name; the second server is not "
                   "used for it",
                   {{"upstream", upstreams_[i].name}, {"dataset", info.name}});
        }
      }
    }
  }
  if (!has_list) co_return tl::unexpected(*failure);
  const auto catalogue = std::make_shared<DatasetCatalogue>();
  for (const auto& [name, dataset] : merged) {
    std::vector<std::string> names;
    for (const std::size_t replica : dataset->replicas) names.push_back(upstreams_[replica].name);
    std::vector<std::size_t> ordered;
    for (const std::size_t at : rendezvous_order(name, names)) {
      ordered.push_back(dataset->replicas[at]);
    }
    dataset->replicas = std::move(ordered);
    catalogue->add(dataset);
  }
  co_return catalogue;
}

// ---- choosing a server

asio::awaitable<std::vector<std::size_t>> UpstreamPool::reachable_replicas(
    std::shared_ptr<const UpstreamDataset> dataset, std::string token) {
  const auto offered = co_await catalogue(std::move(token));
  if (!offered) co_return dataset->replicas;
  const auto now =
      std::dynamic_pointer_cast<const UpstreamDataset>((*offered)->find(dataset->info().name));
  co_return now && now->info() == dataset->info() ? now->replicas : dataset->replicas;
}

// A recently lost server may be retried soon, but after the reachable ones.
std::vector<std::size_t> UpstreamPool::by_preference(std::vector<std::size_t> replicas) const {
  std::stable_partition(replicas.begin(), replicas.end(),
                        [this](std::size_t i) { return !upstreams_[i].health.has_failed(); });
  return replicas;
}

asio::awaitable<Result<UpstreamPool::Reached>> UpstreamPool::reach(
    std::shared_ptr<const UpstreamDataset> dataset, UpstreamClient client,
    std::function<bool()> is_wanted) {
  const Clock::time_point deadline = Clock::now() + options_.failover_timeout;
  std::vector<std::size_t> replicas = dataset->replicas;
  for (;;) {
    Error failure = {ErrorCode::kUnavailable, kNoUpstream};
    for (const std::size_t replica : by_preference(replicas)) {
      if (!upstreams_[replica].health.may_be_tried(Clock::now())) continue;
      auto link = co_await link_to(replica, client);
      if (link) co_return Reached{.link = *std::move(link), .upstream = replica};
      failure = link.error();
    }
    if (is_stopped_ || !is_wanted() || failure.code != ErrorCode::kUnavailable ||
        Clock::now() >= deadline) {
      co_return tl::unexpected(failure);
    }
    co_await pause(executor_, options_.min_backoff);
    replicas = co_await reachable_replicas(dataset, client.token);
  }
}

}  // namespace multitetra
