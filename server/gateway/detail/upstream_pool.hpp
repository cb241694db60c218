// Tracks the upstreams: which are reachable, what they serve, and which one serves a request.
//
// One thread: everything runs on the executor.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/net/async_event.hpp"
#include "common/net/endpoint.hpp"
#include "server/gateway/detail/upstream_health.hpp"
#include "server/gateway/detail/upstream_link.hpp"
#include "server/gateway/upstream_options.hpp"
#include "server/operations/prometheus_metrics.hpp"
#include "server/service/dataset_catalogue.hpp"
#include "server/service/tile_cache.hpp"

namespace multitetra {

// A dataset as several servers offer it. The servers make its steps.
class UpstreamDataset : public SurfaceProvider {
 public:
  explicit UpstreamDataset(DatasetInfo info) : info_(std::move(info)) {}

  [[nodiscard]] const DatasetInfo& info() const override { return info_; }
  [[nodiscard]] bool sends_shells() const override { return shells; }
  [[nodiscard]] TiledStep make(const StepRequest& step, std::stop_token stop) const override;
  [[nodiscard]] SizeEstimates sizes(std::stop_token stop, SizeAccuracy accuracy) const override;

  // Upstreams with exactly this dataset, the preferred one first.
  std::vector<std::size_t> replicas = {};
  // Whether each of them sends sample shells to the clients that it was listed for.
  bool shells = true;

 private:
  DatasetInfo info_;
};

// The client on whose behalf a request is forwarded.
struct UpstreamClient {
  std::string token = {};
  std::string share = {};    // As ConnectionContext::share(); empty: for the gateway itself.
  std::string address = {};  // For the servers' logs.
  bool shells = false;       // It decodes them, and may.
};

class UpstreamPool {
 public:
  UpstreamPool(asio::any_io_executor executor, UpstreamOptions options);

  // Lists the datasets of the reachable servers for the bearer of the token (unless the gateway has
  // its own): of datasets with the same name that differ, that of the first server. An error when
  // none can be reached, or all refuse the token. Concurrent callers are answered
  // together.
  [[nodiscard]] asio::awaitable<Result<CataloguePtr>> catalogue(std::string token);

  // A link to the first server with the dataset that can be reached, also to one that was away when
  // the catalogue was made; waits at most the failover timeout, and while is_wanted() is true.
  struct Reached {
    LinkPtr link;
    std::size_t upstream = 0;
    // An earlier stream used it: it may have closed unnoticed.
    bool was_used = false;
  };
  [[nodiscard]] asio::awaitable<Result<Reached>> reach(
      std::shared_ptr<const UpstreamDataset> dataset, UpstreamClient client,
      std::function<bool()> is_wanted);
  // The link to it was lost: others are preferred for a moment.
  void lost(std::size_t upstream);
  // It sent a tile that is not what it promised: it is left out for a while.
  void sent_damaged_tile(std::size_t upstream, const std::string& why);
  [[nodiscard]] bool may_be_asked(std::size_t upstream) const {
    return upstreams_[upstream].health.may_be_asked(Clock::now());
  }

  // Whether a server is there.
  [[nodiscard]] bool is_ready() const;
  [[nodiscard]] std::vector<UpstreamState> upstreams() const;
  // The number of datasets in the last listing.
  [[nodiscard]] std::size_t datasets() const { return datasets_; }
  // Keeps a link to every server, to know at once when it goes and when it is back. Until stop().
  void monitor_upstreams();
  void stop();
  // For links from now on.
  void use(UpstreamSecrets secrets);
  [[nodiscard]] TileCache& tiles() { return tiles_; }
  [[nodiscard]] const UpstreamOptions& options() const { return options_; }

 private:
  using Clock = UpstreamHealth::Clock;
  struct Upstream {
    std::string name;
    UpstreamHealth health;
    std::uint64_t damaged_tiles = 0;  // Damaged tiles that it has sent.
    LinkPtr watched = nullptr;
    std::unique_ptr<asio::steady_timer> timer = nullptr;  // Until it is tried again.
    bool requires_token = false;  // It refused the gateway, which has none of its own.
  };
  struct CachedCatalogue {
    Clock::time_point at = {};
    CataloguePtr catalogue;
  };
  // A listing in progress, shared by all callers with the same token.
  struct PendingListing {
    explicit PendingListing(asio::any_io_executor executor) : done(executor) {}
    AsyncEvent done;
    std::optional<Result<CataloguePtr>> result;
  };

  [[nodiscard]] std::string shown(const std::string& token) const;
  [[nodiscard]] asio::awaitable<Result<LinkPtr>> link_to(std::size_t upstream,
                                                         UpstreamClient client);
  [[nodiscard]] LinkOptions link_options() const;
  // Whether a server that requires a token of the gateway's clients answers; needs no token.
  [[nodiscard]] asio::awaitable<void> ping(std::size_t upstream);
  // What one server offers to the bearer of a token.
  struct Listing {
    std::vector<DatasetInfo> datasets;
    bool shells = false;  // It sends sample shells.
  };
  [[nodiscard]] asio::awaitable<Result<Listing>> list_of(std::size_t upstream, std::string token);
  [[nodiscard]] std::vector<std::size_t> by_preference(std::vector<std::size_t> replicas) const;
  [[nodiscard]] asio::awaitable<Result<CataloguePtr>> list_all(std::string token);
  [[nodiscard]] asio::awaitable<std::vector<std::size_t>> reachable_replicas(
      std::shared_ptr<const UpstreamDataset> dataset, std::string token);
  asio::awaitable<void> monitor(std::size_t upstream);
  void note(std::size_t upstream, bool is_reached, const std::string& why);

  asio::any_io_executor executor_;
  UpstreamOptions options_;
  std::vector<Upstream> upstreams_;
  std::map<std::string, CachedCatalogue> catalogues_;  // By token.
  std::map<std::string, std::shared_ptr<PendingListing>> pending_listings_;
  std::size_t datasets_ = 0;
  TileCache tiles_;
  bool is_stopped_ = false;
};

}  // namespace multitetra
