// A gateway's requests other than streams: queries, and surfaces assembled by the gateway.
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "common/base/in_parallel.hpp"
#include "common/net/coroutines.hpp"
#include "server/gateway/detail/remote_caller.hpp"
#include "server/gateway/detail/upstream_tiles.hpp"
#include "server/service/run_on_workers.hpp"
#include "server/session/answers.hpp"

namespace multitetra {
namespace {

// Returns the server's reply if its type matches the query.
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

// Assembling a mesh of this size takes noticeable time.
constexpr std::uint64_t kManyTriangles = 200'000;

}  // namespace

// ---- queries

void RemoteCaller::answer(RunQuery action, std::stop_token,
                          std::function<void(Result<DatasetQueryReply>)> done) {
  spawn(executor_,
        [self = shared_from_this(), action = std::move(action), done = std::move(done)]() mutable {
          return self->forward_query(std::move(action), std::move(done));
        });
}

asio::awaitable<void> RemoteCaller::forward_query(
    RunQuery action, std::function<void(Result<DatasetQueryReply>)> done) {
  const auto self = shared_from_this();
  auto dataset = std::dynamic_pointer_cast<const UpstreamDataset>(action.source);
  UpstreamClient client = upstream_client();
  auto answer = co_await queries_.request(std::move(dataset), std::move(client), action.query);
  if (!answer) {
    done(tl::unexpected(answer.error()));
  } else if (auto* refusal = std::get_if<ErrorReply>(&*answer)) {
    done(tl::unexpected(refusal->error));
  } else if (auto reply = reply_to(action.query, *std::move(answer))) {
    done(*std::move(reply));
  } else {
    done(fail(ErrorCode::kInternal,
              std::string("A server sent an unexpected reply to a request of the kind ") +
                  kind_of(action.query) + "."));
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
      // close() triggers `changed` as well.
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

asio::awaitable<void> RemoteCaller::forward_surface(StartStream action, std::uint64_t max_triangles,
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
    return assembled(std::move(*tiles), stop);
  };
  auto surface = co_await run_on_workers<Surface>(assembling_, client()->share(),
                                                  is_large ? "large mesh" : "small mesh", is_large,
                                                  stop, std::move(assemble));
  if (!surface && surface.error().code == ErrorCode::kDamagedData && reached_) {
    upstreams_->sent_damaged_tile(reached_->upstream, surface.error().text);
  }
  done(std::move(surface));
}

void RemoteCaller::make_surface(StartStream action, std::uint64_t max_triangles,
                                std::stop_token stop, std::function<void(Result<Surface>)> done) {
  spawn(executor_, [self = shared_from_this(), action = std::move(action), max_triangles,
                    stop = std::move(stop), done = std::move(done)]() mutable {
    return self->forward_surface(std::move(action), max_triangles, std::move(stop),
                                 std::move(done));
  });
}

}  // namespace multitetra
