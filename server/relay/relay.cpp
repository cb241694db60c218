#include "server/relay/relay.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <utility>

#include <spdlog/spdlog.h>

#include "server/relay/rendezvous.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kMaxOffers = 256;

asio::awaitable<void> pause(asio::any_io_executor executor, std::chrono::milliseconds time) {
  asio::steady_timer timer(executor, time);
  boost::system::error_code ignored;
  co_await timer.async_wait(use_error(ignored));
}

}  // namespace

EncodedStep RelayedDataset::make(const StepRequest&, std::stop_token) const {
  throw std::logic_error("A relay makes no steps.");
}
StepSizes RelayedDataset::sizes(std::stop_token, SizeAccuracy) const {
  throw std::logic_error("A relay measures no steps.");
}

Relay::Relay(asio::any_io_executor executor, RelayOptions options)
    : executor_(executor),
      options_(std::move(options)),
      tiles_(options_.tile_bytes),
      timer_(executor) {
  for (const Endpoint& upstream : options_.upstreams) {
    upstreams_.push_back({.name = to_string(upstream)});
  }
}

void Relay::note(std::size_t upstream, bool is_reached) {
  Upstream& one = upstreams_[upstream];
  const bool was_reached = one.backoff.count() == 0;
  if (is_reached) {
    one.backoff = {};
    one.not_before = {};
  } else {
    one.backoff = std::clamp(2 * one.backoff, options_.least_backoff, options_.most_backoff);
    one.not_before = Clock::now() + one.backoff;
  }
  if (is_reached != was_reached) {
    spdlog::warn("{} {}", one.name, is_reached ? "is back" : "cannot be reached");
  }
}

void Relay::lost(std::size_t upstream) {
  note(upstream, false);
  offers_.clear();
}

bool Relay::is_ready() const {
  return std::any_of(upstreams_.begin(), upstreams_.end(),
                     [](const Upstream& one) { return one.backoff.count() == 0; });
}

// A server that refuses us is there all the same.
asio::awaitable<Result<LinkPtr>> Relay::link_to(std::size_t upstream, std::string token) {
  Hello hello{.token = std::move(token), .agent = "multitetra-gateway/" MULTITETRA_VERSION};
  auto link = co_await UpstreamLink::connect(executor_, options_.upstreams[upstream],
                                             std::move(hello), options_.connect_timeout);
  note(upstream, link || link.error().code != ErrorCode::kUnavailable);
  co_return link;
}

asio::awaitable<Result<std::vector<DatasetInfo>>> Relay::list_of(std::size_t upstream,
                                                                 std::string token) {
  const auto link = co_await link_to(upstream, std::move(token));
  if (!link) co_return tl::unexpected(link.error());
  (*link)->send(ListDatasets{.request_id = 1});
  auto answer = co_await (*link)->receive();
  (*link)->close();
  if (!answer) co_return tl::unexpected(answer.error());
  if (auto* list = std::get_if<DatasetList>(&*answer)) co_return std::move(list->datasets);
  if (const auto* error = std::get_if<ErrorReply>(&*answer)) co_return tl::unexpected(error->error);
  co_return fail(ErrorCode::kInternal, "A server did not answer with its list of datasets.");
}

asio::awaitable<Result<CataloguePtr>> Relay::catalogue(std::string token) {
  if (const auto known = offers_.find(token);
      known != offers_.end() && Clock::now() - known->second.at < options_.list_lifetime) {
    co_return known->second.catalogue;
  }
  std::map<std::string, std::shared_ptr<RelayedDataset>> merged;
  std::optional<Error> trouble;
  bool has_list = false;
  // Servers that failed lately come last, and are left alone where another one has answered.
  for (const bool is_late : {false, true}) {
    for (std::size_t i = 0; i < upstreams_.size(); ++i) {
      if ((upstreams_[i].backoff.count() != 0) != is_late || (is_late && has_list)) continue;
      auto list = co_await list_of(i, token);
      if (!list) {
        if (!trouble || trouble->code == ErrorCode::kUnavailable) trouble = list.error();
        continue;
      }
      has_list = true;
      for (DatasetInfo& info : *list) {
        auto& dataset = merged[info.name];
        if (!dataset) dataset = std::make_shared<RelayedDataset>(info);
        if (dataset->info() == info) {
          dataset->holders.push_back(i);
        } else {
          spdlog::warn("{} has another dataset \"{}\" than the server before it; it is not asked",
                       upstreams_[i].name, info.name);
        }
      }
    }
  }
  if (!has_list) co_return tl::unexpected(*trouble);
  const auto catalogue = std::make_shared<DatasetCatalogue>();
  for (const auto& [name, dataset] : merged) {
    std::vector<std::string> names;
    for (const std::size_t holder : dataset->holders) names.push_back(upstreams_[holder].name);
    std::vector<std::size_t> ordered;
    for (const std::size_t at : rendezvous_order(name, names)) {
      ordered.push_back(dataset->holders[at]);
    }
    dataset->holders = std::move(ordered);
    catalogue->add(dataset);
  }
  if (offers_.size() >= kMaxOffers) offers_.clear();
  offers_[token] = {.at = Clock::now(), .catalogue = catalogue};
  co_return catalogue;
}

asio::awaitable<Result<Relay::Reached>> Relay::reach(std::vector<std::size_t> holders,
                                                     std::string token,
                                                     std::function<bool()> is_wanted) {
  const Clock::time_point deadline = Clock::now() + options_.patience;
  for (;;) {
    Error trouble = {ErrorCode::kUnavailable, "No server that has this dataset can be reached."};
    for (const std::size_t holder : holders) {
      if (Clock::now() < upstreams_[holder].not_before) continue;
      auto link = co_await link_to(holder, token);
      if (link) co_return Reached{.link = *std::move(link), .upstream = holder};
      trouble = link.error();
    }
    if (is_stopped_ || !is_wanted() || trouble.code != ErrorCode::kUnavailable ||
        Clock::now() >= deadline) {
      co_return tl::unexpected(trouble);
    }
    co_await pause(executor_, options_.least_backoff);
  }
}

asio::awaitable<void> Relay::look_after_upstreams() {
  while (!is_stopped_) {
    for (std::size_t i = 0; i < upstreams_.size(); ++i) {
      const Upstream& one = upstreams_[i];
      if (one.backoff.count() == 0 || Clock::now() < one.not_before) continue;
      const auto link = co_await link_to(i, {});
      if (link) (*link)->close();
    }
    timer_.expires_after(options_.least_backoff);
    boost::system::error_code ignored;
    co_await timer_.async_wait(use_error(ignored));
  }
}

void Relay::stop() {
  is_stopped_ = true;
  timer_.cancel();
}

}  // namespace multitetra
