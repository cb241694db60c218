#include "server/gateway/detail/remote_service_client.hpp"

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include "common/net/coroutines.hpp"
#include "server/gateway/detail/upstream_tiles.hpp"
#include "server/operations/log.hpp"
#include "server/session/answers.hpp"

namespace multitetra {
namespace {

// Keeps only the servers that also have the coloring dataset and all further datasets. Returns
// false if there are none.
bool keep_holders_of_all(ValidatedStream& action) {
  std::vector<SurfaceProviderPtr> others = action.further;
  if (action.scalars) others.push_back(action.scalars);
  if (others.empty()) return true;
  const auto first = std::dynamic_pointer_cast<const UpstreamDataset>(action.source);
  auto all = std::make_shared<UpstreamDataset>(*first);
  for (const SurfaceProviderPtr& other : others) {
    const auto& replicas = std::dynamic_pointer_cast<const UpstreamDataset>(other)->replicas;
    std::erase_if(all->replicas, [&](std::size_t replica) {
      return std::find(replicas.begin(), replicas.end(), replica) == replicas.end();
    });
  }
  const bool is_held = !all->replicas.empty();
  action.source = std::move(all);
  return is_held;
}

}  // namespace

asio::awaitable<Result<CataloguePtr>> RemoteServiceClient::catalogue_for(std::string token) {
  token_ = token;
  auto found = co_await upstreams_->catalogue(std::move(token));
  if (found) catalogue_ = *found;
  co_return found;
}

UpstreamClient RemoteServiceClient::upstream_client() const {
  constexpr std::size_t kMaxShareNameBytes = 256;  // Token names may be long.
  return {.token = token_,
          .share = client()->quota_key().substr(0, kMaxShareNameBytes),
          .address = client()->facts().peer};
}

void RemoteServiceClient::when_closed() {
  is_closed_ = true;
  if (reached_) reached_->link->close();
  queries_.close();
  if (const StreamPtr stream = stream_) {
    stream->fail({ErrorCode::kCancelled, "The client has disconnected."});
  }
  change_.notify_all();
}

// ---- streams

ProgressiveStreamPtr RemoteServiceClient::steps(ValidatedStream action,
                                                std::function<void()> changed) {
  const bool is_held = keep_holders_of_all(action);
  stream_ = std::make_shared<RemoteStream>(
      std::move(action), RemoteStream::Events{.changed = std::move(changed),
                                              .taken =
                                                  [weak = weak_from_this()] {
                                                    if (const auto self = weak.lock())
                                                      self->change_.notify_all();
                                                  },
                                              .stopped =
                                                  [weak = weak_from_this()](RemoteStream& stopped) {
                                                    if (const auto self = weak.lock())
                                                      self->cancel(stopped);
                                                  }});
  const ProgressiveStreamPtr started = stream_;
  if (!is_held) {
    stream_->refuse({ErrorCode::kUnavailable,
                     "No server behind this gateway has all datasets of this request: the "
                     "surface's dataset and "
                     "the one to color it by, or all further ones."});
  }
  change_.notify_all();
  if (!std::exchange(is_forwarding_, true)) {
    spawn(executor_, [self = shared_from_this()] { return self->forward_streams(); });
  }
  return started;
}

void RemoteServiceClient::cancel(RemoteStream& stream) {
  if (std::exchange(stream.is_requested, false) && reached_) {
    reached_->link->send(Cancel{stream.id()});
  }
  if (stream_.get() == &stream) stream_.reset();
  change_.notify_all();
}

asio::awaitable<void> RemoteServiceClient::forward_streams() {
  const auto self = shared_from_this();
  while (!is_closed_) {
    if (const StreamPtr stream = stream_; stream && !stream->is_stopped) {
      co_await forward_stream(stream);
    } else {
      co_await change_.wait();
    }
  }
  if (reached_) reached_->link->close();
}

asio::awaitable<bool> RemoteServiceClient::reach_dataset(StreamPtr stream) {
  const std::vector<std::size_t> replicas = stream->dataset->replicas;
  const bool is_there =
      reached_ && !reached_->link->is_lost() && upstreams_->may_be_tried(reached_->upstream) &&
      std::find(replicas.begin(), replicas.end(), reached_->upstream) != replicas.end();
  if (is_there) co_return true;
  if (reached_) reached_->link->close();
  reached_.reset();
  std::function<bool()> is_wanted = [this, stream] { return !stream->is_stopped && !is_closed_; };
  UpstreamClient client = upstream_client();  // Not in the awaiting expression; see upstream_pool.
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

asio::awaitable<void> RemoteServiceClient::forward_stream(StreamPtr stream) {
  while (!stream->is_stopped && co_await reach_dataset(stream)) {
    // An idle link may have been closed meanwhile, which says nothing about its server.
    const bool may_be_stale = std::exchange(reached_->was_used, true);
    stream->forwarded.restart();
    reached_->link->send(stream->forwarded.open());
    stream->is_requested = true;
    if (co_await forward(stream)) co_return;
    stream->is_requested = false;
    if (may_be_stale) continue;
    upstreams_->report_lost_stream(reached_->upstream, client()->facts().connection, stream->id());
    const RemoteStream::Clock::time_point now = RemoteStream::Clock::now();
    if (!stream->lost_at) stream->lost_at = now;
    if (now - *stream->lost_at > upstreams_->options().failover_timeout) {
      stream->fail(
          {ErrorCode::kUnavailable, "No server can provide this stream; try again later."});
    }
  }
}

asio::awaitable<bool> RemoteServiceClient::forward(StreamPtr stream) {
  const std::uint64_t id = stream->id();
  const LinkPtr link = reached_->link;
  for (;;) {
    auto message = co_await link->receive();
    if (!message) co_return stream->is_stopped || is_closed_;
    const bool is_end = is_last(*message);
    // An error without a request id comes from a stopping server: treated as lost.
    if (is_end && request_id_of(*message) == 0) {
      link->close();
      co_return stream->is_stopped || is_closed_;
    }
    if (request_id_of(*message) != id) continue;
    if (!stream->is_stopped && is_shutdown_notice(*message)) {
      link->close();
      co_return false;
    }
    if (is_end) stream->is_requested = false;
    if (!stream->is_stopped) take(stream, *std::move(message));
    if (is_end) co_return true;
    while (!stream->is_stopped && !is_closed_ && !stream->has_room()) co_await change_.wait();
  }
}

void RemoteServiceClient::take(const StreamPtr& stream, ServerMessage message) {
  if (is_last(message)) {
    stream->put(std::move(message));
    return;
  }
  switch (stream->forwarded.next(message)) {
    case ForwardedStream::Verdict::kSkip:
      return;
    case ForwardedStream::Verdict::kDiffers:
      stream->fail({ErrorCode::kUnavailable,
                    "The connection to a server was lost, and another server sent a different "
                    "reply; try again."});
      return;
    case ForwardedStream::Verdict::kForward:
      break;
  }
  stream->lost_at.reset();
  if (const auto* tile = std::get_if<Tile>(&message)) keep(*stream, *tile);
  stream->put(std::move(message));
}

// The check runs on another thread; forwarding does not wait for it.
void RemoteServiceClient::keep(const RemoteStream& stream, const Tile& tile) {
  constexpr std::size_t kMaxUncheckedTiles = 64;  // Tiles beyond that are not cached.
  const StepBegin& step = stream.forwarded.step();
  const OpenStream& open = stream.forwarded.open();
  const bool is_further = !open.further_datasets.empty() && tile.step > 0;
  if (step.request.normal_bits != 0 || tile.index >= step.tiles.size()) return;
  if (is_further && tile.step > open.further_datasets.size()) return;
  const TileSummary& summary = step.tiles[tile.index];
  const TileKey key = {
      .digest = summary.digest,
      .cube = summary.cube,
      .appearance = step.shell ? kShellAppearance : 0,
      .dataset = is_further ? open.further_datasets[tile.step - 1] : stream.dataset->info().name};
  if (upstreams_->tiles().has_all({&key, 1}) || assembling_.waiting() >= kMaxUncheckedTiles) return;
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
  assembling_.post({.share = client()->quota_key(), .number = queue_number_},
                   {.run = std::move(check), .kind = "tile check"});
}

}  // namespace multitetra
