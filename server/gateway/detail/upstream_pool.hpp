// Tracks the upstreams: which ones are reachable, what they offer, and which one serves a request.
//
// Single-threaded: everything runs on the executor.
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

// A dataset offered by one or more servers, which make its steps.
class UpstreamDataset : public SurfaceProvider {
 public:
  explicit UpstreamDataset(DatasetInfo info) : info_(std::move(info)) {}

  [[nodiscard]] const DatasetInfo& info() const override { return info_; }
  [[nodiscard]] bool sends_shells() const override { return shells; }
  [[nodiscard]] EncodedStep make(const StepRequest& step, std::stop_token stop) const override;
  [[nodiscard]] SizeEstimates sizes(std::stop_token stop, SizeAccuracy accuracy) const override;

  // Upstreams with exactly this dataset, the preferred one first.
  std::vector<std::size_t> replicas = {};
  // Whether all replicas send sample shells to the clients that they listed the dataset for.
  bool shells = true;

 private:
  DatasetInfo info_;
};

// The client on whose behalf a request is forwarded.
struct UpstreamClient {
  std::string token = {};
  std::string share = {};    // ConnectionContext::quota_key(); empty for the gateway itself.
  std::string address = {};  // Address for the servers' logs.
  // Decodes sample shells and may receive them.
  bool shells = false;
};

class UpstreamPool {
 public:
  UpstreamPool(asio::any_io_executor executor, UpstreamOptions options);

  // Lists the datasets of the reachable servers for a token (or the gateway's own token, if it has
  // one). If datasets of one name differ, that of the first server is used. Fails if no server can
  // be reached, or all refuse the token. Concurrent callers share one listing.
  [[nodiscard]] asio::awaitable<Result<CataloguePtr>> catalogue(std::string token);

  // Returns a link to the first reachable server with the dataset, including servers that were
  // unreachable when the catalogue was made. Waits at most for the failover timeout, and only while
  // is_wanted() is true.
  struct Reached {
    LinkPtr link;
    std::size_t upstream = 0;
    // Used by an earlier stream, so it may have been closed unnoticed.
    bool was_used = false;
  };
  [[nodiscard]] asio::awaitable<Result<Reached>> reach(
      std::shared_ptr<const UpstreamDataset> dataset, UpstreamClient client,
      std::function<bool()> is_wanted);
  // Reports that the link to a server was lost: others are preferred for a while.
  void report_lost(std::size_t upstream);
  // Reports the same for a link with a running stream, which is retried at another server.
  void report_lost_stream(std::size_t upstream, std::uint64_t connection, std::uint64_t request);
  // Excludes a server for a while because it sent a tile that differs from its summary.
  void sent_damaged_tile(std::size_t upstream, const std::string& why);
  [[nodiscard]] bool may_be_tried(std::size_t upstream) const {
    return upstreams_[upstream].health.may_be_tried(Clock::now());
  }

  // Returns whether any server is reachable.
  [[nodiscard]] bool is_ready() const;
  [[nodiscard]] std::vector<UpstreamState> upstreams() const;
  // Returns the number of datasets in the last listing.
  [[nodiscard]] std::size_t datasets() const { return datasets_; }
  // Keeps a link to every server until stop(), to detect at once when one is lost or back.
  void monitor_upstreams();
  void stop();
  // Sets the secrets for further links.
  void use(UpstreamSecrets secrets);
  [[nodiscard]] TileCache& tiles() { return tiles_; }
  [[nodiscard]] const UpstreamOptions& options() const { return options_; }

 private:
  using Clock = UpstreamHealth::Clock;
  struct Upstream {
    std::string name;
    UpstreamHealth health;
    std::uint64_t damaged_tiles = 0;
    std::uint64_t lost_streams = 0;
    LinkPtr watched = nullptr;
    // Expires at the next attempt.
    std::unique_ptr<asio::steady_timer> timer = nullptr;
    // Whether the server refused a Hello without a token, even if its Pong does not report this.
    bool requires_token = false;
    // Whether it was logged that the server requires no token.
    bool is_known_open = false;
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

  [[nodiscard]] std::string token_for_upstream(const std::string& token) const;
  [[nodiscard]] asio::awaitable<Result<LinkPtr>> link_to(std::size_t upstream,
                                                         UpstreamClient client);
  [[nodiscard]] LinkOptions link_options() const;
  // Returns whether the server is reachable and does not say that it requires a token.
  [[nodiscard]] asio::awaitable<bool> ping(std::size_t upstream);
  // The datasets that one server offers for a token.
  struct Listing {
    std::vector<DatasetInfo> datasets;
    // The server sends sample shells.
    bool shells = false;
  };
  [[nodiscard]] asio::awaitable<Result<Listing>> list_of(std::size_t upstream, std::string token);
  [[nodiscard]] std::vector<std::size_t> by_preference(std::vector<std::size_t> replicas) const;
  [[nodiscard]] asio::awaitable<Result<CataloguePtr>> list_all(std::string token);
  [[nodiscard]] asio::awaitable<std::vector<std::size_t>> reachable_replicas(
      std::shared_ptr<const UpstreamDataset> dataset, std::string token);
  asio::awaitable<void> monitor(std::size_t upstream);
  void record_attempt(std::size_t upstream, bool is_reached, const std::string& why);

  asio::any_io_executor executor_;
  UpstreamOptions options_;
  std::vector<Upstream> upstreams_;
  std::map<std::string, CachedCatalogue> catalogues_;  // Keyed by token.
  std::map<std::string, std::shared_ptr<PendingListing>> pending_listings_;
  std::size_t datasets_ = 0;
  TileCache tiles_;
  bool is_stopped_ = false;
};

}  // namespace multitetra
