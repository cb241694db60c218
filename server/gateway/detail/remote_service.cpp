#include "server/gateway/detail/remote_service.hpp"

#include <algorithm>
#include <deque>
#include <iterator>
#include <optional>
#include <utility>

#include "common/base/in_parallel.hpp"
#include "common/net/async_event.hpp"
#include "common/net/coroutines.hpp"
#include "server/gateway/detail/forwarded_stream.hpp"
#include "server/gateway/detail/upstream_queries.hpp"
#include "server/gateway/detail/upstream_tiles.hpp"
#include "server/operations/log.hpp"
#include "server/service/run_on_workers.hpp"
#include "server/session/answers.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kMaxWaiting = 4;  // Beyond that nothing is read from a server.

// The reply of a server, if it has the kind that answers the query.
std::optional<DatasetQueryReply> reply_to(const DatasetQuery& query, ServerMessage message) {
  if (std::holds_alternative<Estimate>(query)) {
    if (auto* reply = std::get_if<EstimateReply>(&message)) return *reply;
  } else if (std::holds_alternative<Slice>(query)) {
    if (auto* reply = std::get_if<SliceReply>(&message)) return std::move(*reply);
  } else if (auto* reply = std::get_if<ProbeReply>(&message)) {
    return std::move(*reply);
  }
  return std::nullopt;
}

// A server must have what colors a surface as well. False where none has both.
bool keep_holders_of_scalars(StartStream& action) {
  if (!action.scalars) return true;
  const auto surface = std::dynamic_pointer_cast<const UpstreamDataset>(action.source);
  const auto field = std::dynamic_pointer_cast<const UpstreamDataset>(action.scalars);
  auto both = std::make_shared<UpstreamDataset>(surface->info());
  std::copy_if(surface->replicas.begin(), surface->replicas.end(),
               std::back_inserter(both->replicas), [&](std::size_t replica) {
                 return std::find(field->replicas.begin(), field->replicas.end(), replica) !=
                        field->replicas.end();
               });
  const bool is_held = !both->replicas.empty();
  action.source = std::move(both);
  return is_held;
}

// A mesh of so many triangles takes noticeable time.
constexpr std::uint64_t kManyTriangles = 200'000;

class RemoteCaller : public Caller, public std::enable_shared_from_this<RemoteCaller> {
 public:
  RemoteCaller(asio::any_io_executor executor, std::shared_ptr<UpstreamPool> upstreams,
               Workers& assembling, ConnectionContextPtr client, RequestLimits limits)
      : Caller(std::move(client), limits),
        executor_(executor),
        upstreams_(std::move(upstreams)),
        assembling_(assembling),
        queue_number_(assembling.new_client()),
        queries_(upstreams_),
        change_(executor) {}

  CataloguePtr catalogue() const override { return catalogue_; }
  ProgressiveStreamPtr steps(StartStream action, std::function<void()> changed) override;
  void answer(RunQuery action, std::stop_token stop,
              std::function<void(Result<DatasetQueryReply>)> done) override;
  void keep_time(std::chrono::steady_clock::time_point) override {}

 protected:
  std::optional<asio::awaitable<Result<CataloguePtr>>> fetch_catalogue(std::string token) override {
    return offered(std::move(token));
  }
  void make_surface(StartStream action, std::uint64_t max_triangles, std::stop_token stop,
                    std::function<void(Result<Surface>)> done) override;
  void when_closed() override;

 private:
  class Stream;
  using StreamPtr = std::shared_ptr<Stream>;

  asio::awaitable<Result<CataloguePtr>> offered(std::string token);
  // Brings all streams, one after the other, until it is closed.
  asio::awaitable<void> bring_streams();
  asio::awaitable<void> bring(StreamPtr stream);
  // Makes sure that reached_ has the dataset; false when the stream cannot continue.
  asio::awaitable<bool> reach_holder(StreamPtr stream);
  // Until the stream is over (true) or the server lost (false).
  asio::awaitable<bool> forward(StreamPtr stream);
  void take(const StreamPtr& stream, ServerMessage message);
  // For clients that ask for it by its digest, unless it is damaged.
  void keep(const Stream& stream, const Tile& tile);
  void cancel(Stream& stream);
  [[nodiscard]] UpstreamClient upstream_client() const;
  asio::awaitable<void> bring_answer(RunQuery action,
                                     std::function<void(Result<DatasetQueryReply>)> done);
  asio::awaitable<void> bring_surface(StartStream action, std::uint64_t max_triangles,
                                      std::stop_token stop,
                                      std::function<void(Result<Surface>)> done);
  // All tiles of a stream's only step, and the memory that they take.
  struct Collected {
    SurfaceTiles tiles;
    ByteReservations::Reservation memory = {};
  };
  asio::awaitable<Result<Collected>> collect(StartStream action, std::uint64_t max_triangles);

  asio::any_io_executor executor_;
  std::shared_ptr<UpstreamPool> upstreams_;
  Workers& assembling_;
  std::uint64_t queue_number_;
  UpstreamQueries queries_;
  CataloguePtr catalogue_;
  std::string token_;
  bool is_closed_ = false;
  bool is_bringing_ = false;
  StreamPtr stream_;  // Null when none runs.
  // The connection of the last stream, reused by the next one.
  std::optional<UpstreamPool::Reached> reached_;
  AsyncEvent change_;
};

class RemoteCaller::Stream : public ProgressiveStream {
 public:
  using Clock = std::chrono::steady_clock;

  Stream(std::weak_ptr<RemoteCaller> caller, StartStream action, std::function<void()> changed)
      : forwarded(std::move(action.open)),
        dataset(std::dynamic_pointer_cast<const UpstreamDataset>(action.source)),
        shells(action.shells),
        changed_(std::move(changed)),
        caller_(std::move(caller)) {}

  std::optional<ServerMessage> take() override {
    if (waiting_.empty()) return std::nullopt;
    ServerMessage message = std::move(waiting_.front());
    waiting_.pop_front();
    if (std::holds_alternative<StepEnd>(message)) ++steps_sent_;
    if (const auto caller = caller_.lock()) caller->change_.notify_all();
    return message;
  }
  void end(StreamOutcome outcome) override {
    finish(StreamEnd{.request_id = id(), .outcome = outcome, .steps = steps_sent_});
  }
  void fail(Error error) override {
    finish(ErrorReply{.request_id = id(), .error = std::move(error)});
  }
  void drop() override {
    is_finished_ = true;
    waiting_.clear();
    stop();
  }

  // Before the client received anything of the step.
  void refuse(Error error) {
    waiting_.push_back(ErrorReply{.request_id = id(), .error = std::move(error)});
    is_finished_ = is_stopped = true;
  }
  // A message of the server; the last one ends the stream behind those that wait.
  void put(ServerMessage message) {
    const bool is_end = is_last(message);
    waiting_.push_back(std::move(message));
    if (is_end) is_stopped = true;
    changed_();
  }
  [[nodiscard]] bool has_room() const { return waiting_.size() < kMaxWaiting; }
  [[nodiscard]] std::uint64_t id() const { return forwarded.open().request_id; }

  ForwardedStream forwarded;
  std::shared_ptr<const UpstreamDataset> dataset;
  const bool shells;  // Its steps may have them; the same for all streams of a client.
  // A server is working on it.
  bool is_asked = false;
  bool is_stopped = false;
  std::optional<Clock::time_point> lost_at = {};  // Its server; none since a message was passed on.

 private:
  // The last message, in the place of what waits.
  void finish(ServerMessage last) {
    if (std::exchange(is_finished_, true)) return;
    waiting_.clear();
    waiting_.push_back(std::move(last));
    stop();
    changed_();
  }
  // Cancels the stream at the server. Then its link is free for the
  // next stream.
  void stop() {
    is_stopped = true;
    if (const auto caller = caller_.lock()) caller->cancel(*this);
  }

  bool is_finished_ = false;  // The last message was decided here.
  std::deque<ServerMessage> waiting_;
  std::uint32_t steps_sent_ = 0;
  std::function<void()> changed_;
  std::weak_ptr<RemoteCaller> caller_;
};

asio::awaitable<Result<CataloguePtr>> RemoteCaller::offered(std::string token) {
  token_ = token;
  auto found = co_await upstreams_->catalogue(std::move(token));
  if (found) catalogue_ = *found;
  co_return found;
}

UpstreamClient RemoteCaller::upstream_client() const {
  constexpr std::size_t kMostOfAName = 256;  // Names of tokens may be long.
  return {.token = token_, .share = client()->share().substr(0, kMostOfAName)};
}

void RemoteCaller::when_closed() {
  is_closed_ = true;
  if (reached_) reached_->link->close();
  queries_.close();
  if (const StreamPtr stream = stream_) {
    stream->fail({ErrorCode::kCancelled, "The client has disconnected."});
  }
  change_.notify_all();
}

// ---- streams

ProgressiveStreamPtr RemoteCaller::steps(StartStream action, std::function<void()> changed) {
  const bool is_held = keep_holders_of_scalars(action);
  stream_ = std::make_shared<Stream>(weak_from_this(), std::move(action), std::move(changed));
  const ProgressiveStreamPtr started = stream_;
  if (!is_held) {
    stream_->refuse(
        {ErrorCode::kUnavailable,
         "No server behind this gateway has both the surface's dataset and the one that "
         "shall color it."});
  }
  change_.notify_all();
  if (!std::exchange(is_bringing_, true)) {
    spawn(executor_, [self = shared_from_this()] { return self->bring_streams(); });
  }
  return started;
}

void RemoteCaller::cancel(Stream& stream) {
  if (std::exchange(stream.is_asked, false) && reached_) {
    reached_->link->send(Cancel{stream.id()});
  }
  if (stream_.get() == &stream) stream_.reset();
  change_.notify_all();
}

asio::awaitable<void> RemoteCaller::bring_streams() {
  const auto self = shared_from_this();
  while (!is_closed_) {
    if (const StreamPtr stream = stream_; stream && !stream->is_stopped) {
      co_await bring(stream);
    } else {
      co_await change_.wait();
    }
  }
  if (reached_) reached_->link->close();
}

asio::awaitable<bool> RemoteCaller::reach_holder(StreamPtr stream) {
  const std::vector<std::size_t> replicas = stream->dataset->replicas;
  const bool is_there =
      reached_ && !reached_->link->is_lost() && upstreams_->may_be_asked(reached_->upstream) &&
      std::find(replicas.begin(), replicas.end(), reached_->upstream) != replicas.end();
  if (is_there) co_return true;
  if (reached_) reached_->link->close();
  reached_.reset();
  std::function<bool()> is_wanted = [this, stream] { return !stream->is_stopped && !is_closed_; };
  UpstreamClient client = upstream_client();  // Not in the awaiting expression: see upstream_pool.
  client.shells = stream->shells;
  auto reached = co_await upstreams_->reach(stream->dataset, std::move(client), is_wanted);
  if (!is_wanted()) {
    if (reached) (*reached).link->close();
    co_return false;
  }
  if (reached) {
    reached_ = *std::move(reached);
    co_return true;
  }
  stream->fail(reached.error());
  co_return false;
}

asio::awaitable<void> RemoteCaller::bring(StreamPtr stream) {
  while (!stream->is_stopped && co_await reach_holder(stream)) {
    // A link that has been idle may have been closed since; that says nothing about its server.
    const bool may_be_stale = std::exchange(reached_->was_used, true);
    stream->forwarded.restart();
    reached_->link->send(stream->forwarded.open());
    stream->is_asked = true;
    if (co_await forward(stream)) co_return;
    stream->is_asked = false;
    if (may_be_stale) continue;
    log_line(LogLevel::kWarning, "upstream lost in a stream; trying another one",
             {{"connection", client()->facts().connection}, {"request", stream->id()}});
    upstreams_->lost(reached_->upstream);
    const Stream::Clock::time_point now = Stream::Clock::now();
    if (!stream->lost_at) stream->lost_at = now;
    if (now - *stream->lost_at > upstreams_->options().failover_timeout) {
      stream->fail({ErrorCode::kUnavailable, "No server brings this stream; try again later."});
    }
  }
}

asio::awaitable<bool> RemoteCaller::forward(StreamPtr stream) {
  const std::uint64_t id = stream->id();
  const LinkPtr link = reached_->link;
  for (;;) {
    auto message = co_await link->receive();
    if (!message) co_return stream->is_stopped || is_closed_;
    const bool is_end = is_last(*message);
    // A stopping server sends an error and closes the connection: treated as lost.
    if (is_end && request_id_of(*message) == 0) {
      link->close();
      co_return stream->is_stopped || is_closed_;
    }
    if (request_id_of(*message) != id) continue;
    if (!stream->is_stopped && is_shutdown_notice(*message)) {
      link->close();
      co_return false;
    }
    if (is_end) stream->is_asked = false;
    if (!stream->is_stopped) take(stream, *std::move(message));
    if (is_end) co_return true;
    while (!stream->is_stopped && !is_closed_ && !stream->has_room()) co_await change_.wait();
  }
}

void RemoteCaller::take(const StreamPtr& stream, ServerMessage message) {
  if (is_last(message)) {
    stream->put(std::move(message));
    return;
  }
  switch (stream->forwarded.next(message)) {
    case ForwardedStream::Verdict::kPassOver:
      return;
    case ForwardedStream::Verdict::kDiffers:
      stream->fail({ErrorCode::kUnavailable,
                    "A server was lost, and another one has a different answer; try again."});
      return;
    case ForwardedStream::Verdict::kForward:
      break;
  }
  stream->lost_at.reset();
  if (const auto* tile = std::get_if<Tile>(&message)) keep(*stream, *tile);
  stream->put(std::move(message));
}

// Checked on another thread: what passes does not wait for it.
void RemoteCaller::keep(const Stream& stream, const Tile& tile) {
  constexpr std::size_t kMostUnchecked = 64;  // Beyond that a tile is kept another time.
  const StepBegin& step = stream.forwarded.step();
  if (step.request.normal_bits != 0 || tile.index >= step.tiles.size()) return;
  const TileSummary& summary = step.tiles[tile.index];
  const TileKey key = {.digest = summary.digest,
                       .cube = summary.cube,
                       .appearance = step.shell ? kShellAppearance : 0,
                       .dataset = stream.dataset->info().name};
  if (upstreams_->tiles().has_all({&key, 1}) || assembling_.waiting() >= kMostUnchecked) return;
  StepBegin of_step = {
      .request = step.request, .finest_spacing = step.finest_spacing, .shell = step.shell};
  auto check = [upstreams = upstreams_, executor = executor_, upstream = reached_->upstream, key,
                encoded = EncodedTile{.summary = summary, .payload = tile.payload}, of_step] {
    const auto checked = check_tile(encoded, of_step);
    if (checked) {
      upstreams->tiles().add(key, encoded);
      return;
    }
    multitetra::post(executor,
                     [weak = std::weak_ptr(upstreams), upstream, why = checked.error().text] {
                       if (const auto all = weak.lock()) all->sent_damaged_tile(upstream, why);
                     });
  };
  assembling_.post({.share = client()->share(), .number = queue_number_},
                   {.run = std::move(check), .kind = "tile check"});
}

// ---- queries

void RemoteCaller::answer(RunQuery action, std::stop_token,
                          std::function<void(Result<DatasetQueryReply>)> done) {
  spawn(executor_,
        [self = shared_from_this(), action = std::move(action), done = std::move(done)]() mutable {
          return self->bring_answer(std::move(action), std::move(done));
        });
}

asio::awaitable<void> RemoteCaller::bring_answer(
    RunQuery action, std::function<void(Result<DatasetQueryReply>)> done) {
  const auto self = shared_from_this();
  auto dataset = std::dynamic_pointer_cast<const UpstreamDataset>(action.source);
  UpstreamClient client = upstream_client();
  auto answer = co_await queries_.ask(std::move(dataset), std::move(client), action.query);
  if (!answer) {
    done(tl::unexpected(answer.error()));
  } else if (auto* refusal = std::get_if<ErrorReply>(&*answer)) {
    done(tl::unexpected(refusal->error));
  } else if (auto reply = reply_to(action.query, *std::move(answer))) {
    done(*std::move(reply));
  } else {
    done(fail(ErrorCode::kInternal, std::string("A server answered something else than a ") +
                                        kind_of(action.query) + " asks for."));
  }
}

// ---- surfaces

asio::awaitable<Result<RemoteCaller::Collected>> RemoteCaller::collect(
    StartStream action, std::uint64_t max_triangles) {
  const auto changed = std::make_shared<AsyncEvent>(executor_);
  const ProgressiveStreamPtr stream =
      steps(std::move(action), [changed] { changed->notify_all(); });
  Collected collected;
  SurfaceTiles& tiles = collected.tiles;
  for (;;) {
    auto message = stream->take();
    if (is_closed_) co_return fail(ErrorCode::kCancelled, "The client has disconnected.");
    if (!message) {
      // Closing this changes the stream as well.
      co_await changed->wait();
    } else if (const auto* error = std::get_if<ErrorReply>(&*message)) {
      co_return tl::unexpected(error->error);
    } else if (auto* begin = std::get_if<StepBegin>(&*message)) {
      tiles.begin = std::move(*begin);
      tiles.payloads.resize(tiles.begin.tiles.size());
      if (tiles.begin.scalars) tiles.scalars.resize(tiles.begin.tiles.size());
      if (const auto allowed = check_triangles(tiles.begin, max_triangles); !allowed) {
        stream->drop();
        co_return tl::unexpected(allowed.error());
      }
      auto memory = client()->reserve(bytes_of_tiles(tiles.begin));
      if (!memory) {
        stream->drop();
        co_return tl::unexpected(memory.error());
      }
      collected.memory = *std::move(memory);
    } else if (auto* tile = std::get_if<Tile>(&*message)) {
      if (tile->index < tiles.payloads.size()) tiles.payloads[tile->index] = tile->payload;
    } else if (auto* scalars = std::get_if<TileScalars>(&*message)) {
      if (scalars->index < tiles.scalars.size()) tiles.scalars[scalars->index] = scalars->codes;
    } else if (const auto* step = std::get_if<StepEnd>(&*message)) {
      tiles.digest = step->digest;
    } else if (const auto* end = std::get_if<StreamEnd>(&*message)) {
      stream->drop();
      if (end->outcome == StreamOutcome::kComplete) co_return collected;
      co_return fail(ErrorCode::kUnavailable, "The server is stopping; retry later.");
    }
  }
}

asio::awaitable<void> RemoteCaller::bring_surface(StartStream action, std::uint64_t max_triangles,
                                                  std::stop_token stop,
                                                  std::function<void(Result<Surface>)> done) {
  const auto self = shared_from_this();
  auto collected = co_await collect(std::move(action), max_triangles);
  if (!collected) {
    done(tl::unexpected(collected.error()));
    co_return;
  }
  const bool is_large = triangles_of(collected->tiles.begin) > kManyTriangles;
  const auto tiles = std::make_shared<SurfaceTiles>(std::move(collected->tiles));
  std::function<Result<Surface>()> assemble = [tiles, stop] {
    return assembled_or_why_not(std::move(*tiles), stop);
  };
  auto surface = co_await run_on_workers<Surface>(assembling_, client()->share(),
                                                  is_large ? "large mesh" : "small mesh", is_large,
                                                  std::move(assemble));
  if (!surface && surface.error().code == ErrorCode::kDamagedData && reached_) {
    upstreams_->sent_damaged_tile(reached_->upstream, surface.error().text);
  }
  done(std::move(surface));
}

void RemoteCaller::make_surface(StartStream action, std::uint64_t max_triangles,
                                std::stop_token stop, std::function<void(Result<Surface>)> done) {
  spawn(executor_, [self = shared_from_this(), action = std::move(action), max_triangles,
                    stop = std::move(stop), done = std::move(done)]() mutable {
    return self->bring_surface(std::move(action), max_triangles, std::move(stop), std::move(done));
  });
}

}  // namespace

// ---- the service

RemoteService::RemoteService(asio::any_io_executor executor,
                             std::shared_ptr<UpstreamPool> upstreams, RequestLimits limits)
    : executor_(std::move(executor)), upstreams_(std::move(upstreams)), limits_(limits) {}
RemoteService::~RemoteService() = default;

CallerPtr RemoteService::open(ConnectionContextPtr client) {
  return std::make_shared<RemoteCaller>(executor_, upstreams_, assembling_, std::move(client),
                                        limits_);
}

std::optional<TileCache::Found> RemoteService::find_tile(const ContentDigest& digest,
                                                         const TileCache::MaySee& may_see) {
  return upstreams_->tiles().find_by_digest(digest, may_see);
}

}  // namespace multitetra
