#include "client/library/stream_validator.hpp"

#include <algorithm>

#include "client/library/detail/manifest_checks.hpp"

namespace multitetra {
namespace {

// Messages of an earlier stream may still arrive; messages of a later one cannot exist.
Result<bool> belongs(std::uint64_t request_id, std::uint64_t current, std::uint32_t step,
                     const char* what) {
  if (request_id <= current) return request_id == current;
  return step_fault(step, std::string(what) + " a request that was never made");
}

std::string sizes(std::uint64_t tiles, std::uint64_t bytes) {
  return std::to_string(tiles) + " tiles and " + std::to_string(bytes) + " bytes";
}

}  // namespace

StreamValidator::StreamValidator(DatasetInfo info, OpenStream open, std::set<ContentDigest> held,
                                 AssemblerLimits limits)
    : info_(std::move(info)), open_(std::move(open)), limits_(limits), held_(std::move(held)) {
  if (is_of_several())
    limits_.steps = 1 + static_cast<std::uint32_t>(open_.further_datasets.size());
}

Result<bool> StreamValidator::accept(const ServerMessage& message) {
  return std::visit([this](const auto& m) { return take(m); }, message);
}

Result<bool> StreamValidator::take(const ErrorReply& reply) {
  if (reply.request_id != open_.request_id && reply.request_id != 0) return false;
  is_step_open_ = false;
  has_ended_ = true;
  return true;
}

Result<bool> StreamValidator::take(const StepBegin& begin) {
  const auto ours = belongs(begin.request_id, open_.request_id, begin.step, "it belongs to");
  if (!ours || !*ours) return ours;
  if (has_ended_) return step_fault(begin.step, "it begins after the end of its stream");
  if (is_step_open_) return step_fault(begin.step, "it begins before the previous step has ended");
  if (begin.step != steps_ended_) {
    return step_fault(begin.step, "step " + std::to_string(steps_ended_) + " was expected");
  }
  if (step_ && step_->is_final) return step_fault(begin.step, "it follows the final step");
  if (begin.step >= limits_.steps) {
    return step_fault(begin.step, "this client allows " + std::to_string(limits_.steps) + " steps");
  }
  if (const auto found = manifest_fault(begin, open_, info_, limits_)) {
    return step_fault(begin.step, *found);
  }
  if (is_of_several()) {
    if (begin.is_final) return step_fault(begin.step, "it is final, and only a preview was due");
    held_.clear();  // Each dataset has tiles of its own.
  }
  for (const TileSummary& tile : begin.tiles) {
    if (!held_.contains(tile.digest)) announced_.add(tile);
  }
  if (const auto beyond = exceeded_limits(announced_, limits_)) {
    return step_fault(begin.step, "with the previous steps " + *beyond);
  }
  step_ = begin;
  is_step_open_ = true;
  tiles_received_ = 0;
  bytes_received_ = 0;
  return true;
}

Result<bool> StreamValidator::take(const Tile& tile) {
  const auto ours = belongs(tile.request_id, open_.request_id, tile.step, "a tile belongs to");
  if (!ours || !*ours) return ours;
  if (!is_step_open_ || tile.step != step_->step) {
    return step_fault(tile.step, "a tile arrived outside of its step");
  }
  if (tile.index >= step_->tiles.size()) {
    return step_fault(tile.step, "tile " + std::to_string(tile.index) +
                                     " was sent, but the number of tiles is " +
                                     std::to_string(step_->tiles.size()));
  }
  const TileSummary& promised = step_->tiles[tile.index];
  if (!held_.insert(promised.digest).second) {
    return step_fault(tile.step, tile_name(*step_, tile.index) + " was sent again");
  }
  const std::size_t bytes = tile.payload ? tile.payload->size() : 0;
  if (bytes != promised.bytes) {
    return step_fault(tile.step, tile_name(*step_, tile.index) + " has " + std::to_string(bytes) +
                                     " bytes; the manifest lists " +
                                     std::to_string(promised.bytes));
  }
  ++tiles_received_;
  bytes_received_ += bytes;
  return true;
}

Result<bool> StreamValidator::take(const TileScalars& scalars) {
  const auto ours =
      belongs(scalars.request_id, open_.request_id, scalars.step, "scalars belong to");
  if (!ours || !*ours) return ours;
  if (!is_step_open_ || scalars.step != step_->step) {
    return step_fault(scalars.step, "scalars arrived outside of their step");
  }
  if (!step_->scalars) return step_fault(scalars.step, "scalars were not requested");
  if (scalars.index >= step_->tiles.size() || !held_.contains(step_->tiles[scalars.index].digest)) {
    return step_fault(scalars.step, "scalars arrived for tile " + std::to_string(scalars.index) +
                                        ", which was not received");
  }
  return true;
}

Result<bool> StreamValidator::take(const StepEnd& end) {
  const auto ours = belongs(end.request_id, open_.request_id, end.step, "its end belongs to");
  if (!ours || !*ours) return ours;
  if (!is_step_open_ || end.step != step_->step) {
    return step_fault(end.step, "it ends without having begun");
  }
  ContentDigest sum;
  for (std::size_t i = 0; i < step_->tiles.size(); ++i) {
    const ContentDigest& digest = step_->tiles[i].digest;
    if (!held_.contains(digest)) {
      return step_fault(end.step, "it ends without " + tile_name(*step_, i));
    }
    sum += digest;
  }
  if (end.tiles_sent != tiles_received_ || end.payload_bytes != bytes_received_) {
    return step_fault(end.step, "the server counts " + sizes(end.tiles_sent, end.payload_bytes) +
                                    "; " + sizes(tiles_received_, bytes_received_) +
                                    " were received");
  }
  if (sum != end.digest) {
    return step_fault(end.step,
                      "its digest is " + sum.hex() + "; the server sent " + end.digest.hex());
  }
  is_step_open_ = false;
  ++steps_ended_;
  return true;
}

Result<bool> StreamValidator::take(const StreamEnd& end) {
  if (end.request_id < open_.request_id) return false;
  const auto reject = [](const std::string& what) {
    return fail(ErrorCode::kDamagedData, "The stream's end: " + what + ".");
  };
  if (end.request_id != open_.request_id)
    return reject("it belongs to a request that was never made");
  if (has_ended_) return reject("it was sent twice");
  if (end.steps != steps_ended_) {
    return reject("the server counts " + std::to_string(end.steps) + " steps; " +
                  std::to_string(steps_ended_) + " were received");
  }
  const bool is_enough =
      step_ && !is_step_open_ && (step_->is_final || open_.steps == StepPolicy::kPreviewsOnly);
  if (end.outcome == StreamOutcome::kComplete && !is_enough) {
    return reject("it is marked as complete, but the final step is missing");
  }
  if (end.outcome == StreamOutcome::kComplete && is_of_several() && steps_ended_ < limits_.steps) {
    return reject("it claims to be complete without the previews of all datasets");
  }
  is_step_open_ = false;
  has_ended_ = true;
  return true;
}

}  // namespace multitetra
