#include "client/library/fetch.hpp"

namespace multitetra {

Fetch::Fetch(Client& client, const DatasetInfo& info, OpenStream open, const FetchOptions& options)
    : client_(client),
      own_tiles_(
          {.tiles = client.options().limits.tiles, .triangles = client.options().limits.triangles}),
      stream_(client, options.tiles != nullptr ? *options.tiles : own_tiles_),
      retries_(options.retries) {
  stream_.set_tile_listener(options.on_tile);
  sent_ = stream_.open(info, std::move(open));
}

ClientResult<std::optional<FetchedStep>> Fetch::next() {
  for (;;) {
    auto news = sent_ ? stream_.next(client_.options().timeout)
                      : ClientResult<StreamUpdate>(tl::unexpected(sent_.error()));
    if (!news) {
      if (stream_.received().tiles > tiles_before_) retries_.progress();
      tiles_before_ = stream_.received().tiles;
      if (!retries_.wait_after(news.error().error)) return tl::unexpected(news.error());
      sent_ = stream_.resume();
    } else if (auto* step = std::get_if<FetchedStep>(&*news)) {
      return *std::move(step);
    } else if (const auto* end = std::get_if<StreamEnded>(&*news)) {
      if (end->outcome == StreamOutcome::kComplete) return std::nullopt;
      return fail(ErrorSource::kServer,
                  {ErrorCode::kCancelled, "The server ended the stream before its final step."});
    } else if (!stream_.is_running()) {
      return std::nullopt;
    }
  }
}

ClientResult<void> Fetch::cancel() {
  if (auto sent = stream_.cancel(); !sent) return sent;
  while (stream_.is_running()) {
    if (const auto news = stream_.next(client_.options().timeout); !news) {
      return tl::unexpected(news.error());
    }
  }
  return {};
}

}  // namespace multitetra
