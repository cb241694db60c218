#include "server/stream/stream_messages.hpp"

#include <cassert>
#include <iterator>
#include <utility>

#include "server/core/thresholds/threshold_map.hpp"

namespace multitetra {

StreamMessages::StreamMessages(const OpenStream& open, const DatasetInfo& info,
                               std::optional<ScalarRange> scalars, bool shells)
    : request_id_(open.request_id),
      info_(info),
      state_{.request = open.request,
             .steps = open.steps,
             .resumed_previews = open.resumed_previews,
             .triangles_per_second = open.triangles_per_second,
             .shells = shells,
             .use = open.use,
             .drawable_triangles = open.drawable_triangles},
      scalars_(scalars),
      known_(open.cached_tile_digests.begin(), open.cached_tile_digests.end()),
      datasets_(1 + open.further_datasets.size()) {}

std::optional<StreamState> StreamMessages::take_request() {
  if (phase_ != Phase::kWanted) return std::nullopt;
  phase_ = Phase::kMaking;
  return state_;
}

void StreamMessages::supply(StepResult step, double seconds) {
  if (phase_ != Phase::kMaking) return;
  if (step.is_over) {
    end(StreamOutcome::kComplete);
    return;
  }
  begin(std::move(step), seconds);
}

void StreamMessages::supply(std::vector<StepResult> previews, double seconds) {
  if (phase_ != Phase::kMaking) return;
  assert(!previews.empty());
  seconds_a_preview_ = seconds / static_cast<double>(previews.size());
  previews_.assign(std::make_move_iterator(previews.begin()),
                   std::make_move_iterator(previews.end()));
  begin_next_preview();
}

// A client keeps the tiles of each dataset apart, so each has all of its own.
void StreamMessages::begin_next_preview() {
  known_.clear();
  StepResult next = std::move(previews_.front());
  previews_.pop_front();
  begin(std::move(next), seconds_a_preview_);
}

void StreamMessages::begin(StepResult step, double seconds) {
  current_ = std::move(step);
  next_tile_ = 0;
  totals_ = {.request_id = request_id_, .step = step_, .digest = {}, .seconds = seconds};
  for (const EncodedTile& tile : current_.encoded.tiles) totals_.digest += tile.summary.digest;
  phase_ = Phase::kBegin;
}

void StreamMessages::end(StreamOutcome outcome) {
  finish_with(StreamEnd{.request_id = request_id_, .outcome = outcome, .steps = step_});
}

void StreamMessages::fail(Error error) {
  finish_with(ErrorReply{.request_id = request_id_, .error = std::move(error)});
}

bool StreamMessages::has_message() const {
  return phase_ == Phase::kBegin || phase_ == Phase::kTiles || phase_ == Phase::kLast;
}

ServerMessage StreamMessages::take() {
  assert(has_message());
  if (phase_ == Phase::kBegin) {
    phase_ = Phase::kTiles;
    return step_begin();
  }
  if (phase_ == Phase::kTiles) return next_tile_or_end();
  phase_ = Phase::kFinished;
  return std::move(last_);
}

StepBegin StreamMessages::step_begin() const {
  const StepRequest& step = current_.step;
  StepBegin begin{.request_id = request_id_,
                  .step = step_,
                  .is_final = current_.is_final,
                  .request = step.request,
                  .error_bound_world = step.shell
                                           ? error_bound(*step.shell, info_, step.finest_spacing)
                                           : largest_threshold(step.request, info_),
                  .finest_spacing = step.finest_spacing,
                  .shell = step.shell,
                  .tetrahedra = current_.encoded.tetrahedra,
                  .active_tetrahedra = current_.encoded.active_tetrahedra,
                  .tiles = {}};
  // Reports the request as the client sent it; separate fields describe what the preview omits.
  begin.is_unsimplified = state_.request.simplify && !step.request.simplify && !step.shell;
  begin.request.simplify = state_.request.simplify;
  begin.crossed_octants = current_.encoded.crossed_octants;
  begin.scalars = scalars_;
  begin.tiles.reserve(current_.encoded.tiles.size());
  for (const EncodedTile& tile : current_.encoded.tiles) begin.tiles.push_back(tile.summary);
  return begin;
}

std::optional<Tile> StreamMessages::tile_to_send() {
  const EncodedTile& tile = current_.encoded.tiles[next_tile_];
  if (!known_.insert(tile.summary.digest).second) return std::nullopt;
  ++totals_.tiles_sent;
  totals_.payload_bytes += tile.payload->size();
  return Tile{.request_id = request_id_,
              .step = step_,
              .index = static_cast<std::uint32_t>(next_tile_),
              .payload = tile.payload};
}

std::optional<TileScalars> StreamMessages::scalars_to_send() {
  if (!scalars_) return std::nullopt;
  const TileSummary& tile = current_.encoded.tiles[next_tile_].summary;
  if (!known_scalars_.insert(tile.digest).second) return std::nullopt;
  const ScalarsOfTile& scalars = current_.scalars[next_tile_];
  return TileScalars{.request_id = request_id_,
                     .step = step_,
                     .index = static_cast<std::uint32_t>(next_tile_),
                     .codes = scalars.codes,
                     .largest_deviation = scalars.largest_deviation};
}

ServerMessage StreamMessages::next_tile_or_end() {
  for (; next_tile_ < current_.encoded.tiles.size(); ++next_tile_) {
    if (auto tile = tile_to_send()) return *std::move(tile);
    if (auto scalars = scalars_to_send()) return *std::move(scalars);
  }
  StepEnd totals = totals_;
  ++step_;
  if (datasets_ > 1) {
    after_preview();
    return totals;
  }
  state_ = std::move(current_.after);
  state_.delivered.push_back(
      {.step = current_.step, .size = size_of(current_.encoded), .seconds = totals.seconds});
  const bool was_final = current_.is_final;
  current_ = {};
  phase_ = Phase::kWanted;
  if (was_final) end(StreamOutcome::kComplete);
  return totals;
}

void StreamMessages::after_preview() {
  current_ = {};
  phase_ = Phase::kWanted;
  if (!previews_.empty()) {
    begin_next_preview();
  } else if (step_ == datasets_) {
    end(StreamOutcome::kComplete);
  }
}

void StreamMessages::finish_with(ServerMessage last) {
  if (phase_ == Phase::kLast || phase_ == Phase::kFinished) return;
  current_ = {};
  previews_.clear();
  last_ = std::move(last);
  phase_ = Phase::kLast;
}

}  // namespace multitetra
