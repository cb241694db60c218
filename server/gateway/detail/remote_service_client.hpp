// One client of a gateway: forwards its streams and queries to the servers that have the dataset.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "common/net/async_event.hpp"
#include "server/gateway/detail/remote_stream.hpp"
#include "server/gateway/detail/upstream_pool.hpp"
#include "server/gateway/detail/upstream_queries.hpp"
#include "server/service/surface_service.hpp"
#include "server/service/workers.hpp"

namespace multitetra {

class RemoteServiceClient : public ServiceClient,
                            public std::enable_shared_from_this<RemoteServiceClient> {
 public:
  RemoteServiceClient(asio::any_io_executor executor, std::shared_ptr<UpstreamPool> upstreams,
                      Workers& assembling, ConnectionContextPtr client, RequestLimits limits)
      : ServiceClient(std::move(client), limits),
        executor_(executor),
        upstreams_(std::move(upstreams)),
        assembling_(assembling),
        queue_number_(assembling.new_client()),
        queries_(upstreams_),
        change_(executor) {}

  CataloguePtr catalogue() const override { return catalogue_; }
  ProgressiveStreamPtr steps(ValidatedStream action, std::function<void()> changed) override;
  void answer(ValidatedQuery action, std::stop_token stop, UseReply use, QueryDone done) override;
  void enforce_limits(std::chrono::steady_clock::time_point) override {}

 protected:
  std::optional<asio::awaitable<Result<CataloguePtr>>> fetch_catalogue(std::string token) override {
    return catalogue_for(std::move(token));
  }
  void make_surface(ValidatedStream action, std::uint64_t max_triangles, std::string what,
                    std::stop_token stop, UseSurface use,
                    std::function<void(Result<void>)> done) override;
  void when_closed() override;

 private:
  using StreamPtr = std::shared_ptr<RemoteStream>;

  asio::awaitable<Result<CataloguePtr>> catalogue_for(std::string token);
  // Forwards all streams, one after the other, until closed.
  asio::awaitable<void> forward_streams();
  asio::awaitable<void> forward_stream(StreamPtr stream);
  // Ensures that reached_ has the dataset. Returns false if the stream cannot continue.
  asio::awaitable<bool> reach_dataset(StreamPtr stream);
  // Forwards until the stream is over (true) or the server is lost (false).
  asio::awaitable<bool> forward(StreamPtr stream);
  void take(const StreamPtr& stream, ServerMessage message);
  // Caches a tile for find_tile(), unless it is damaged.
  void keep(const RemoteStream& stream, const Tile& tile);
  void cancel(RemoteStream& stream);
  [[nodiscard]] UpstreamClient upstream_client() const;
  asio::awaitable<Result<DatasetQueryReply>> forwarded(ValidatedQuery action);
  asio::awaitable<void> forward_query(ValidatedQuery action, std::stop_token stop, UseReply use,
                                      QueryDone done);
  asio::awaitable<void> forward_surface(ValidatedStream action, std::uint64_t max_triangles,
                                        std::string what, std::stop_token stop, UseSurface use,
                                        std::function<void(Result<void>)> done);
  // All tiles of a single-step stream, with their memory reservation.
  struct Collected {
    ReceivedSurface tiles;
    ByteReservations::Reservation memory = {};
  };
  asio::awaitable<Result<Collected>> collect(ValidatedStream action, std::uint64_t max_triangles);

  asio::any_io_executor executor_;
  std::shared_ptr<UpstreamPool> upstreams_;
  Workers& assembling_;
  std::uint64_t queue_number_;
  UpstreamQueries queries_;
  CataloguePtr catalogue_ = std::make_shared<const DatasetCatalogue>();
  std::string token_;
  bool is_closed_ = false;
  bool is_forwarding_ = false;
  StreamPtr stream_;  // Null if none runs.
  // The connection of the previous stream, reused by the next one.
  std::optional<UpstreamPool::Reached> reached_;
  AsyncEvent change_;
};

}  // namespace multitetra
