// The operations of a server as functions, the only interface for all transports. Implemented by
// the workers of this process (local_service.hpp) or by upstream servers
// (gateway/remote_service.hpp).
//
//   const CallerPtr caller = service.open(client);
//   if (auto known = co_await caller->log_in(token); !known) co_return refusal(known.error());
//   auto surface = co_await caller->surface(
//       {.dataset = "head", .request = {.isovalue = 500.5, .error = 0.5}});
//
// These functions cover admission, the fair queue, memory, caches and time limits. Arguments and
// results are values; within one process nothing is serialized.
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
#include "server/service/permit.hpp"
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

struct SurfaceRequest {
  std::string dataset = {};
  IsosurfaceRequest request = {};
  std::optional<ScalarRequest> scalars = {};
  std::uint64_t max_triangles = std::numeric_limits<std::uint64_t>::max();
};

// The service for one client. A coroutine awaits one call at a time; the streams and queries of a
// conversation may run concurrently.
class Caller {
 public:
  Caller(ConnectionContextPtr client, RequestLimits limits)
      : client_(std::move(client)), limits_(limits) {}
  virtual ~Caller() = default;
  Caller(const Caller&) = delete;
  Caller& operator=(const Caller&) = delete;

  // ---- for single requests: with the rights of the client's token, and memory reservations

  // Checks the token and sets the client's name. Must be called first.
  [[nodiscard]] asio::awaitable<Result<void>> log_in(std::string token);
  [[nodiscard]] const Permit& permit() const { return permit_; }
  // Sets the request id that is sent to upstream servers. Further surfaces of the request get the
  // following ids.
  void set_request_id(std::uint64_t id) { request_ = id; }

  // Returns the final surface, or kLimitExceeded above `max_triangles`.
  [[nodiscard]] asio::awaitable<Result<Surface>> surface(SurfaceRequest query);
  [[nodiscard]] asio::awaitable<Result<EstimateReply>> estimate(std::string dataset,
                                                                IsosurfaceRequest request);
  [[nodiscard]] asio::awaitable<Result<SliceReply>> slice(std::string dataset, SliceRequest slice);
  [[nodiscard]] asio::awaitable<Result<ProbeReply>> probe(std::string dataset, ProbeRequest probe);

  // ---- for conversations, which check their permit and reserve memory themselves

  // Fetches the datasets that a token may see from upstream servers. Returns nullopt if catalogue()
  // has them, and for a token that is not in the access list, which is not sent upstream.
  [[nodiscard]] std::optional<asio::awaitable<Result<CataloguePtr>>> find_catalogue(
      const std::string& token);
  // Returns the datasets currently known.
  [[nodiscard]] virtual CataloguePtr catalogue() const = 0;
  // Begins a progressive stream. The previous one must have been dropped. `changed` is called when
  // another message may be ready.
  [[nodiscard]] virtual ProgressiveStreamPtr steps(StartStream action,
                                                   std::function<void()> changed) = 0;
  // Answers a query. `done` is called exactly once, soon after `stop` is triggered at the latest.
  virtual void answer(RunQuery action, std::stop_token stop,
                      std::function<void(Result<DatasetQueryReply>)> done) = 0;
  // Sets the measured bandwidth to the client, used to plan further steps.
  virtual void set_bandwidth(double /*bytes_per_second*/) {}

  // ---- for both

  // Ends work that exceeds its time limit.
  virtual void enforce_limits(std::chrono::steady_clock::time_point now) = 0;
  // Cancels the client's work because it disconnected, or for the reason `why`.
  void close(std::optional<Error> why = std::nullopt);

  [[nodiscard]] const RequestLimits& limits() const { return limits_; }

 protected:
  virtual void make_surface(StartStream action, std::uint64_t max_triangles, std::stop_token stop,
                            std::function<void(Result<Surface>)> done) = 0;
  [[nodiscard]] virtual std::optional<asio::awaitable<Result<CataloguePtr>>> fetch_catalogue(
      std::string /*token*/) {
    return std::nullopt;
  }
  virtual void when_closed() {}

  [[nodiscard]] const ConnectionContextPtr& client() const { return client_; }

 private:
  [[nodiscard]] asio::awaitable<Result<DatasetQueryReply>> run_query(DatasetQuery query);
  // Returns the reason of close() if that caused the error, else the error.
  [[nodiscard]] Error reason(const Error& error) const;

  ConnectionContextPtr client_;
  RequestLimits limits_;
  Permit permit_;
  std::uint64_t request_ = 1;
  std::uint64_t surfaces_ = 0;
  std::stop_source stop_;
  std::optional<Error> closed_;
};
using CallerPtr = std::shared_ptr<Caller>;

// Outlives its callers.
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

  [[nodiscard]] virtual CallerPtr open(ConnectionContextPtr client) = 0;
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
