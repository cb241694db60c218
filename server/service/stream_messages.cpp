#include "server/service/stream_messages.hpp"

#include <cassert>
#include <utility>

#include "server/core/threshold_map.hpp"

namespace multitetra {

StreamMessages::StreamMessages(const OpenStream& open, const DatasetInfo& info)
    : request_id_(open.request_id),
      plan_(plan_steps(open.request, open.steps == StepPolicy::kProgressive, info)),
      known_(open.held.begin(), open.held.end()) {
  assert(!plan_.empty());
  for (const StepRequest& step : plan_) {
    error_bounds_.push_back(largest_threshold(step.request, info));
  }
}

std::optional<StepRequest> StreamMessages::next_step() {
  if (phase_ != Phase::kWanted) return std::nullopt;
  phase_ = Phase::kMaking;
  return plan_[step_];
}

void StreamMessages::supply(EncodedStep step, double seconds) {
  if (phase_ != Phase::kMaking) return;
  current_ = std::move(step);
  next_tile_ = 0;
  totals_ = {.request_id = request_id_, .step = step_, .digest = {}, .seconds = seconds};
  for (const EncodedTile& tile : current_.tiles) totals_.digest += tile.summary.digest;
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
  if (phase_ == Phase::kTiles) return take_tile_or_end();
  phase_ = Phase::kFinished;
  return std::move(last_);
}

StepBegin StreamMessages::step_begin() const {
  const StepRequest& step = plan_[step_];
  StepBegin begin{.request_id = request_id_,
                  .step = step_,
                  .is_final = step_ + 1 == plan_.size(),
                  .request = step.request,
                  .error_bound_world = error_bounds_[step_],
                  .finest_spacing = step.finest_spacing,
                  .codec = PayloadCodec::kDracoLattice,
                  .tetrahedra = current_.tetrahedra,
                  .active_tetrahedra = current_.active_tetrahedra,
                  .tiles = {}};
  begin.tiles.reserve(current_.tiles.size());
  for (const EncodedTile& tile : current_.tiles) begin.tiles.push_back(tile.summary);
  return begin;
}

ServerMessage StreamMessages::take_tile_or_end() {
  for (; next_tile_ < current_.tiles.size(); ++next_tile_) {
    const EncodedTile& tile = current_.tiles[next_tile_];
    if (!known_.insert(tile.summary.digest).second) continue;
    ++totals_.tiles_sent;
    totals_.payload_bytes += tile.payload->size();
    return Tile{.request_id = request_id_,
                .step = step_,
                .index = static_cast<std::uint32_t>(next_tile_++),
                .payload = tile.payload};
  }
  current_ = {};
  phase_ = Phase::kWanted;
  if (++step_ == plan_.size()) end(StreamOutcome::kComplete);
  return totals_;
}

void StreamMessages::finish_with(ServerMessage last) {
  if (phase_ == Phase::kLast || phase_ == Phase::kFinished) return;
  current_ = {};
  last_ = std::move(last);
  phase_ = Phase::kLast;
}

}  // namespace multitetra
