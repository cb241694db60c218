// The operations of a server, as functions: every transport calls these, and nothing else. The
// workers of this process answer (local_service.hpp), or other servers
// (gateway/remote_service.hpp).
//
//   const CallerPtr caller = service.open(client);
//   if (auto known = co_await caller->log_in(token); !known) co_return refusal(known.error());
//   auto surface = co_await caller->surface({.dataset = "head", .request = {.isovalue = 500.5}});
//
// Admission, the fair queue, memory, caches and limits of time are behind these functions. Values
// go in and come out; where both sides are in one process nothing is serialized.
//
// Everything runs on one executor, of which one thread runs at a time. `changed` and `done` are
// called there as well, never from inside the call that they were given to.
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

// A progressive stream whose steps are being made. Call drop() to cancel it.
class ProgressiveStream {
 public:
  virtual ~ProgressiveStream() = default;

  // The next message, if there is one now. StreamEnd or ErrorReply is the last.
  [[nodiscard]] virtual std::optional<ServerMessage> take() = 0;
  // Drops messages that were not taken yet; the last one remains, to be taken at once. The first of
  // these two decides.
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

// The service for one client. It does one thing at a time for a coroutine; streams and queries of
// a conversation may run beside each other.
class Caller {
 public:
  Caller(ConnectionContextPtr client, RequestLimits limits)
      : client_(std::move(client)), limits_(limits) {}
  virtual ~Caller() = default;
  Caller(const Caller&) = delete;
  Caller& operator=(const Caller&) = delete;

  // ---- for one request: by the rights of the client's token, with reservations for waiting work

  // To be called first: checks the token and sets the client's name.
  [[nodiscard]] asio::awaitable<Result<void>> log_in(std::string token);
  [[nodiscard]] const Permit& permit() const { return permit_; }

  // The final surface. kLimitExceeded for one of more than `max_triangles`.
  [[nodiscard]] asio::awaitable<Result<Surface>> surface(SurfaceRequest query);
  [[nodiscard]] asio::awaitable<Result<EstimateReply>> estimate(std::string dataset,
                                                                IsosurfaceRequest request);
  [[nodiscard]] asio::awaitable<Result<SliceReply>> slice(std::string dataset, SliceRequest slice);
  [[nodiscard]] asio::awaitable<Result<ProbeReply>> probe(std::string dataset, ProbeRequest probe);

  // ---- for conversations, which check with their permit and reserve memory themselves

  // The datasets for the bearer of a token, where that takes a request to other servers; nullopt
  // where catalogue() has them, and for a token that the access list does not contain, which is
  // shown to no other server.
  [[nodiscard]] std::optional<asio::awaitable<Result<CataloguePtr>>> find_catalogue(
      const std::string& token);
  // The datasets on offer, as far as they are known.
  [[nodiscard]] virtual CataloguePtr catalogue() const = 0;
  // Begins a progressive stream; the one before was dropped. `changed` is called when there may be
  // another message.
  [[nodiscard]] virtual ProgressiveStreamPtr steps(StartStream action,
                                                   std::function<void()> changed) = 0;
  // `done` is called exactly once; soon after `stop` is triggered.
  virtual void answer(RunQuery action, std::stop_token stop,
                      std::function<void(Result<DatasetQueryReply>)> done) = 0;
  // The measured bandwidth to the client, by which streams are planned from now on.
  virtual void set_bandwidth(double /*bytes_per_second*/) {}

  // ---- for both

  // Ends what takes longer than it may.
  virtual void keep_time(std::chrono::steady_clock::time_point now) = 0;
  // Cancels the client's work: it has left, or the server ends it for the reason `why`.
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
  [[nodiscard]] asio::awaitable<Result<DatasetQueryReply>> ask(DatasetQuery query);
  // Why there is none, where that is because of close().
  [[nodiscard]] Error reason(const Error& error) const;

  ConnectionContextPtr client_;
  RequestLimits limits_;
  Permit permit_;
  std::uint64_t surfaces_ = 0;  // The number of requested surfaces.
  std::stop_source stop_;
  std::optional<Error> closed_;
};
using CallerPtr = std::shared_ptr<Caller>;

// Outlives its callers.
class SurfaceService {
 public:
  virtual ~SurfaceService() = default;

  // ---- its life beside the requests, as server.hpp calls it

  // The server begins to run.
  virtual void start() {}
  // Reads again what may have changed, such as secrets.
  virtual void reload() {}
  // The server stops: what runs beside the requests ends.
  virtual void stop() {}
  // Ends its threads, whose work may still come back to the executor. No call may follow.
  virtual void join() = 0;
  // For the metrics.
  [[nodiscard]] virtual ServiceState state() const = 0;

  // ---- requests

  [[nodiscard]] virtual CallerPtr open(ConnectionContextPtr client) = 0;
  // A tile without normals that is at hand and may be seen.
  [[nodiscard]] virtual std::optional<TileCache::Found> find_tile(
      const ContentDigest& digest, const TileCache::MaySee& may_see) = 0;
  // Whether new work is accepted, apart from the admission control.
  [[nodiscard]] virtual bool is_ready() const { return true; }
};

// The owner of the executor makes its service. May throw ExitError when files cannot be used.
using MakeService = std::function<std::unique_ptr<SurfaceService>(asio::any_io_executor)>;

// What the metrics show of a cache.
[[nodiscard]] ServiceState state_of(const TileCache& tiles);

}  // namespace multitetra
