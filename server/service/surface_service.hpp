// The operations of a server as functions, the only interface for all transports. Implemented by
// the workers of this process (local_service.hpp) or by upstream servers
// (gateway/remote_service.hpp).
//
//   const ServiceClientPtr client = service.open(connection);
//   if (auto known = co_await client->log_in(token); !known) co_return refusal(known.error());
//   auto file = co_await client->made_from_surfaces<std::string>(
//       {.dataset = "head", .requests = {{.isovalue = 500.5, .error = 0.5}}}, "mesh file",
//       [](std::vector<Surface> surfaces, const std::stop_token&) { return written(surfaces); });
//
// These functions cover admission, the fair queue, memory, caches and time limits. Arguments and
// results are values; within one process nothing is serialized. What is made of a result, such as a
// file or a picture, is made by the worker that has the result, so only it returns to the executor.
//
// Everything runs on one executor with one thread at a time. `changed` and `done` are called on it
// too, never from within the call that received them.
#pragma once

#include <chrono>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "common/net/net.hpp"
#include "common/wire/messages.hpp"
#include "server/operations/admission_control.hpp"
#include "server/operations/prometheus_metrics.hpp"
#include "server/service/client_access.hpp"
#include "server/service/surface.hpp"
#include "server/service/tile_cache.hpp"

namespace multitetra {

// A progressive stream in progress. Call drop() to cancel it.
class ProgressiveStream {
 public:
  virtual ~ProgressiveStream() = default;

  // Returns the next message, if one is ready. The last one is StreamEnd or ErrorReply.
  [[nodiscard]] virtual std::optional<ServerMessage> take() = 0;
  // End the stream: drop the messages that were not taken, and leave a final one to take at once.
  // Only the first call of either function has an effect.
  virtual void end(StreamOutcome outcome) = 0;
  virtual void fail(Error error) = 0;
  // Cancels the stream; its work ends soon.
  virtual void drop() = 0;
};
using ProgressiveStreamPtr = std::shared_ptr<ProgressiveStream>;

// A request for final surfaces of one dataset, at least one.
struct SurfacesRequest {
  std::string dataset = {};
  std::vector<IsosurfaceRequest> requests = {};
  std::optional<ScalarRequest> scalars = {};
  std::uint64_t max_triangles = std::numeric_limits<std::uint64_t>::max();  // Of all together.
};

// Called by the worker that has made the argument, before it returns to the executor.
using UseSurface = std::function<Result<void>(Surface surface, const std::stop_token& stop)>;
using UseReply = std::function<Result<void>(const DatasetQueryReply& reply)>;
// Called on the executor's thread at the end.
using QueryDone = std::function<void(Result<DatasetQueryReply> reply)>;

// The service for one client. A coroutine awaits one call at a time; the streams and queries of a
// conversation may run concurrently.
class ServiceClient {
 public:
  ServiceClient(ConnectionContextPtr client, RequestLimits limits)
      : client_(std::move(client)), limits_(limits) {}
  virtual ~ServiceClient() = default;
  ServiceClient(const ServiceClient&) = delete;
  ServiceClient& operator=(const ServiceClient&) = delete;

  // ---- for single requests: with the rights of the client's token, and memory reservations.
  // `what` names what is made, such as "mesh file", for estimates of its time and for the log.

  // Checks the token and sets the client's name. Must be called first.
  [[nodiscard]] asio::awaitable<Result<void>> log_in(std::string token);
  [[nodiscard]] const ClientAccess& client_access() const { return client_access_; }
  // Sets the request id that is sent to upstream servers. Further surfaces of the request get the
  // following ids.
  void set_request_id(std::uint64_t id) { request_ = id; }

  // Makes the surfaces one after the other, and returns what `make` makes of them. Fails with
  // kLimitExceeded above `max_triangles`.
  template <typename T>
  [[nodiscard]] asio::awaitable<Result<T>> made_from_surfaces(
      SurfacesRequest wanted, std::string what,
      std::function<Result<T>(std::vector<Surface> surfaces, const std::stop_token& stop)> make) {
    const auto made = std::make_shared<std::optional<T>>();
    UseSurfaces use = [made, make = std::move(make)](std::vector<Surface> surfaces,
                                                     const std::stop_token& stop) {
      return stored(make(std::move(surfaces), stop), *made);
    };
    const auto done = co_await use_surfaces(std::move(wanted), std::move(what), std::move(use));
    if (!done) co_return tl::unexpected(done.error());
    co_return **std::move(made);
  }
  [[nodiscard]] asio::awaitable<Result<EstimateReply>> estimate(std::string dataset,
                                                                IsosurfaceRequest request);
  // `use`, if any, is called with a SliceReply.
  [[nodiscard]] asio::awaitable<Result<SliceReply>> slice(std::string dataset, SliceRequest slice,
                                                          UseReply use = {});
  [[nodiscard]] asio::awaitable<Result<ProbeReply>> probe(std::string dataset, ProbeRequest probe);

  // ---- for conversations, which check their access and reserve memory themselves

  // Fetches the datasets that a token may see from upstream servers. Returns nullopt if catalogue()
  // has them, and for a token that is not in the access list, which is not sent upstream.
  [[nodiscard]] std::optional<asio::awaitable<Result<CataloguePtr>>> find_catalogue(
      const std::string& token);
  // Returns the datasets currently known.
  [[nodiscard]] virtual CataloguePtr catalogue() const = 0;
  // Begins a progressive stream. The previous one must have been dropped. `changed` is called when
  // another message may be ready.
  [[nodiscard]] virtual ProgressiveStreamPtr steps(ValidatedStream action,
                                                   std::function<void()> changed) = 0;
  // Answers a query, and calls `use`, if any, with the reply. `done` is called exactly once, soon
  // after `stop` is triggered at the latest.
  virtual void answer(ValidatedQuery action, std::stop_token stop, UseReply use,
                      QueryDone done) = 0;
  // Sets the measured bandwidth to the client, used to plan further steps.
  virtual void set_bandwidth(double /*bytes_per_second*/) {}

  // ---- for both

  // Ends work that exceeds its time limit.
  virtual void enforce_limits(std::chrono::steady_clock::time_point now) = 0;
  // Cancels the client's work because it disconnected, or for the reason `why`.
  void close(std::optional<Error> why = std::nullopt);

  [[nodiscard]] const RequestLimits& limits() const { return limits_; }

 protected:
  // Makes a final surface and calls `use` with it, then `done` on the executor's thread.
  virtual void make_surface(ValidatedStream action, std::uint64_t max_triangles, std::string what,
                            std::stop_token stop, UseSurface use,
                            std::function<void(Result<void>)> done) = 0;
  [[nodiscard]] virtual std::optional<asio::awaitable<Result<CataloguePtr>>> fetch_catalogue(
      std::string /*token*/) {
    return std::nullopt;
  }
  virtual void when_closed() {}

  [[nodiscard]] const ConnectionContextPtr& client() const { return client_; }

 private:
  using UseSurfaces =
      std::function<Result<void>(std::vector<Surface> surfaces, const std::stop_token& stop)>;
  [[nodiscard]] asio::awaitable<Result<void>> use_surfaces(SurfacesRequest wanted, std::string what,
                                                           UseSurfaces use);
  [[nodiscard]] asio::awaitable<Result<DatasetQueryReply>> run_query(DatasetQuery query,
                                                                     UseReply use = {});
  template <typename T>
  [[nodiscard]] static Result<void> stored(Result<T> made, std::optional<T>& place) {
    if (!made) return tl::unexpected(made.error());
    place = *std::move(made);
    return {};
  }
  // Returns the reason of close() if that caused the error, else the error.
  [[nodiscard]] Error reason(const Error& error) const;

  ConnectionContextPtr client_;
  RequestLimits limits_;
  ClientAccess client_access_;
  std::uint64_t request_ = 1;
  std::uint64_t surfaces_ = 0;
  std::stop_source stop_;
  std::optional<Error> closed_;
};
using ServiceClientPtr = std::shared_ptr<ServiceClient>;

// Outlives its clients.
class SurfaceService {
 public:
  virtual ~SurfaceService() = default;

  // ---- life cycle, called by server.hpp

  // Called when the server begins to run.
  virtual void start() {}
  // Reloads files such as secrets. Returns false, and logs why, if the previous ones stay in use.
  [[nodiscard]] virtual bool reload() { return true; }
  // Stops background activity. Called when the server stops.
  virtual void stop() {}
  // Joins the threads, whose work may still be posted to the executor. Must be the last call.
  virtual void join() = 0;
  [[nodiscard]] virtual ServiceState state() const = 0;

  // ---- requests

  [[nodiscard]] virtual ServiceClientPtr open(ConnectionContextPtr client) = 0;
  // Returns a cached tile without normals that the client may see.
  [[nodiscard]] virtual std::optional<TileCache::Found> find_tile(
      const ContentDigest& digest, const TileCache::MaySee& may_see) = 0;
  // Returns whether new work is accepted, apart from admission control.
  [[nodiscard]] virtual bool is_ready() const { return true; }
};

// Makes the service for an executor. May throw ExitError if files cannot be used.
using MakeService = std::function<std::unique_ptr<SurfaceService>(asio::any_io_executor)>;

// Returns the state of a tile cache for the metrics.
[[nodiscard]] ServiceState state_of(const TileCache& tiles);

}  // namespace multitetra
