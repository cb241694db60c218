#include "client/library/surface_stream.hpp"

#include <algorithm>
#include <cassert>

namespace multitetra {
namespace {

using Clock = std::chrono::steady_clock;

}  // namespace

SurfaceStream::SurfaceStream(Client& client, DecodedTileCache& tiles)
    : client_(client), tiles_(tiles) {}

double SurfaceStream::seconds() const {
  return std::chrono::duration<double>(Clock::now() - started_).count();
}

ClientResult<void> SurfaceStream::open(const DatasetInfo& info, OpenStream open) {
  info_ = info;
  open_ = std::move(open);
  given_.clear();
  started_ = Clock::now();
  first_byte_seconds_ = 0;
  return request();
}

ClientResult<void> SurfaceStream::request() {
  if (assembler_) {
    (void)assembler_->decode_waiting();  // Tiles that fail to decode are requested again.
    keep_decoded();
  }
  arrived_.clear();
  open_.request_id = client_.next_request_id();
  open_.cached_tile_digests =
      tiles_.digests_to_name(kMaxHeldDigests, open_.request.normal_bits != 0);
  begun_.reset();
  assembler_.emplace(info_, open_, tiles_.tiles(), client_.options().limits);
  return client_.send(open_);
}

ClientResult<void> SurfaceStream::cancel() {
  if (!is_running()) return {};
  return client_.send(Cancel{open_.request_id});
}

ClientResult<void> SurfaceStream::resume() {
  assert(is_running());
  if (auto connected = client_.reconnect(); !connected) return connected;
  const auto datasets = client_.list_datasets();
  if (!datasets) return tl::unexpected(datasets.error());
  if (std::find(datasets->begin(), datasets->end(), info_) == datasets->end()) {
    return fail(ErrorSource::kServer,
                {ErrorCode::kUnknownDataset,
                 "Since the connection was lost, the server has replaced or removed dataset \"" +
                     info_.name + "\"; fetch it again."});
  }
  return request();
}

ClientResult<StreamUpdate> SurfaceStream::next(std::chrono::milliseconds max_wait) {
  const Clock::time_point until = Clock::now() + max_wait;
  while (is_running()) {
    const auto remaining =
        std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now());
    const auto message =
        client_.receive_within(std::max(remaining, std::chrono::milliseconds::zero()));
    if (!message) return tl::unexpected(message.error());
    if (!*message) return NoUpdate{};
    auto news = take(**message);
    if (!news) {
      // A server that shuts down may be restarted, so the request can be resumed.
      if (news.error().error.code != ErrorCode::kUnavailable) assembler_.reset();
      return tl::unexpected(news.error());
    }
    if (*news) return **std::move(news);
    if (Clock::now() >= until) break;  // Let the caller run even if more messages are waiting.
  }
  return NoUpdate{};
}

ClientResult<std::optional<StreamUpdate>> SurfaceStream::take(const ServerMessage& message) {
  const auto progress = assembler_->receive(message);
  if (!progress) return fail(ErrorSource::kCheck, progress.error());
  if (const auto* begin = std::get_if<StepBegin>(&message);
      begin && begin->request_id == open_.request_id && !record_started_step(*begin, open_)) {
    return fail(ErrorSource::kCheck,
                {ErrorCode::kDamagedData, "Step " + std::to_string(begin->step) +
                                              ": it is not finer than the step before it."});
  }
  keep(message);
  if (const auto* step = std::get_if<CommittedStepPtr>(&*progress)) return take_step(*step);
  if (const auto* refusal = std::get_if<Refusal>(&*progress)) {
    return fail(ErrorSource::kServer, refusal->error);
  }
  if (const auto* end = std::get_if<StreamEnd>(&*progress)) {
    assembler_.reset();
    return StreamEnded{end->outcome};
  }
  return std::nullopt;
}

// After a lost connection the server repeats the steps that were already returned.
ClientResult<std::optional<StreamUpdate>> SurfaceStream::take_step(const CommittedStepPtr& step) {
  const std::size_t number = step->begin.step;
  if (number < given_.size()) {
    if (given_[number] == step->end.digest) return std::nullopt;
    return fail(ErrorSource::kCheck,
                {ErrorCode::kDamagedData,
                 "Step " + std::to_string(number) +
                     ": it differs from the step received before the connection was lost."});
  }
  given_.push_back(step->end.digest);
  shown_ = step;
  return FetchedStep{.step = step, .first_byte_seconds = first_byte_seconds_, .seconds = seconds()};
}

// Updates the tile cache and the counts from a message that the assembler has accepted.
void SurfaceStream::keep(const ServerMessage& message) {
  if (const auto* begin = std::get_if<StepBegin>(&message)) {
    if (begin->request_id != open_.request_id) return;
    if (begin->step >= given_.size()) first_byte_seconds_ = seconds();
    for (const TileSummary& tile : begin->tiles) tiles_.use(tile.digest);
    begun_ = *begin;
  } else if (const auto* tile = std::get_if<Tile>(&message)) {
    if (tile->request_id != open_.request_id) return;
    const TileSummary& summary = begun_->tiles[tile->index];
    arrived_.push_back(summary.digest);
    keep_decoded();
    ++received_.tiles;
    received_.payload_bytes += tile->payload->size();
    if (listener_) listener_(summary, *begun_, *tile->payload);
  } else if (std::holds_alternative<StepEnd>(message)) {
    keep_decoded();
  }
}

void SurfaceStream::keep_decoded() {
  std::erase_if(arrived_, [this](const ContentDigest& digest) {
    const auto found = assembler_->held().find(digest);
    if (found == assembler_->held().end()) return false;
    tiles_.keep(digest, found->second);
    return true;
  });
}

}  // namespace multitetra
