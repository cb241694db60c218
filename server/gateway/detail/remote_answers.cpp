// A gateway's requests other than streams: queries, and surfaces assembled by the gateway.
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "common/base/in_parallel.hpp"
#include "common/net/coroutines.hpp"
#include "server/gateway/detail/remote_service_client.hpp"
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

void RemoteServiceClient::answer(ValidatedQuery action, std::stop_token stop, UseReply use,
                                 QueryDone done) {
  spawn(executor_, [self = shared_from_this(), action = std::move(action), stop = std::move(stop),
                    use = std::move(use), done = std::move(done)]() mutable {
    return self->forward_query(std::move(action), std::move(stop), std::move(use), std::move(done));
  });
}

asio::awaitable<void> RemoteServiceClient::forward_query(ValidatedQuery action,
                                                         std::stop_token stop, UseReply use,
                                                         QueryDone done) {
  const auto self = shared_from_this();
  const std::string kind = kind_of(action.query);
  auto reply = co_await forwarded(std::move(action));
  if (reply && use) {
    std::function<Result<void>()> run = [&] { return use(*reply); };
    const auto used = co_await run_on_workers<void>(assembling_, client()->quota_key(), kind,
                                                    /*is_long=*/false, stop, std::move(run));
    if (!used) reply = tl::unexpected(used.error());
  }
  done(std::move(reply));
}

asio::awaitable<Result<DatasetQueryReply>> RemoteServiceClient::forwarded(ValidatedQuery action) {
  auto dataset = std::dynamic_pointer_cast<const UpstreamDataset>(action.source);
  UpstreamClient client = upstream_client();
  auto answer = co_await queries_.request(std::move(dataset), std::move(client), action.query);
  if (!answer) co_return tl::unexpected(answer.error());
  if (auto* refusal = std::get_if<ErrorReply>(&*answer)) co_return tl::unexpected(refusal->error);
  if (auto reply = reply_to(action.query, *std::move(answer))) co_return *std::move(reply);
  co_return fail(ErrorCode::kInternal,
                 std::string("A server sent an unexpected reply to a request of the kind ") +
                     kind_of(action.query) + ".");
}

// ---- surfaces

asio::awaitable<Result<RemoteServiceClient::Collected>> RemoteServiceClient::collect(
    ValidatedStream action, std::uint64_t max_triangles) {
  const auto changed = std::make_shared<AsyncEvent>(executor_);
  const ProgressiveStreamPtr stream =
      steps(std::move(action), [changed] { changed->notify_all(); });
  Collected collected;
  ReceivedSurface& tiles = collected.tiles;
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

asio::awaitable<void> RemoteServiceClient::forward_surface(ValidatedStream action,
                                                           std::uint64_t max_triangles,
                                                           std::string what, std::stop_token stop,
                                                           UseSurface use,
                                                           std::function<void(Result<void>)> done) {
  const auto self = shared_from_this();
  auto collected = co_await collect(std::move(action), max_triangles);
  if (!collected) {
    done(tl::unexpected(collected.error()));
    co_return;
  }
  const bool is_large = triangles_of(collected->tiles.begin) > kManyTriangles;
  const auto tiles = std::make_shared<ReceivedSurface>(std::move(collected->tiles));
  std::function<Result<void>()> assemble = [tiles, stop, use = std::move(use)]() -> Result<void> {
    auto surface = assembled(std::move(*tiles), stop);
    if (!surface) return tl::unexpected(surface.error());
    return use(*std::move(surface), stop);
  };
  const auto made = co_await run_on_workers<void>(assembling_, client()->quota_key(),
                                                  (is_large ? "large " : "small ") + what, is_large,
                                                  stop, std::move(assemble));
  if (!made && made.error().code == ErrorCode::kDamagedData && reached_) {
    upstreams_->sent_damaged_tile(reached_->upstream, made.error().text);
  }
  done(made);
}

void RemoteServiceClient::make_surface(ValidatedStream action, std::uint64_t max_triangles,
                                       std::string what, std::stop_token stop, UseSurface use,
                                       std::function<void(Result<void>)> done) {
  spawn(executor_, [self = shared_from_this(), action = std::move(action), max_triangles,
                    what = std::move(what), stop = std::move(stop), use = std::move(use),
                    done = std::move(done)]() mutable {
    return self->forward_surface(std::move(action), max_triangles, std::move(what), std::move(stop),
                                 std::move(use), std::move(done));
  });
}

}  // namespace multitetra
