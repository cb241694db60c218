#include "client/load/stream_checks.hpp"

#include <algorithm>

#include "client/manifest_checks.hpp"

namespace multitetra {
namespace {

tl::unexpected<Error> fault(std::uint32_t step, const std::string& what) {
  return fail(ErrorCode::kDamagedData, "Step " + std::to_string(step) + ": " + what + ".");
}

ContentDigest sum_of_digests(const StepBegin& begin) {
  ContentDigest sum;
  for (const TileSummary& tile : begin.tiles) sum += tile.digest;
  return sum;
}

}  // namespace

StreamLedger::StreamLedger(DatasetInfo info, OpenStream open, std::uint32_t tiles_per_decoded,
                           AssemblerLimits limits)
    : info_(std::move(info)),
      open_(std::move(open)),
      tiles_per_decoded_(tiles_per_decoded),
      limits_(limits),
      held_(open_.held.begin(), open_.held.end()) {}

Result<StreamProgress> StreamLedger::receive(const ServerMessage& message) {
  return std::visit([this](const auto& m) { return take(m); }, message);
}

Result<StreamProgress> StreamLedger::take(const ErrorReply& reply) {
  if (reply.request_id != open_.request_id && reply.request_id != 0) return StreamProgress{};
  return Refusal{reply.error};
}

Result<StreamProgress> StreamLedger::take(const StepBegin& begin) {
  if (begin.request_id < open_.request_id) return StreamProgress{};
  if (begin.request_id > open_.request_id) return fault(begin.step, "nobody asked for it");
  if (begun_) return fault(begin.step, "it begins before the step before has ended");
  if (has_final_) return fault(begin.step, "it follows the final step");
  if (begin.step != steps_) return fault(begin.step, "another step was due");
  if (begin.step >= limits_.steps) return fault(begin.step, "that is a step too many");
  if (const auto found = manifest_fault(begin, open_, info_, limits_)) {
    return fault(begin.step, *found);
  }
  begun_ = begin;
  tiles_received_ = 0;
  bytes_received_ = 0;
  return StreamProgress{};
}

Result<StreamProgress> StreamLedger::take(const Tile& tile) {
  if (tile.request_id < open_.request_id) return StreamProgress{};
  if (tile.request_id > open_.request_id) return fault(tile.step, "nobody asked for its tile");
  if (!begun_ || tile.step != begun_->step || tile.index >= begun_->tiles.size()) {
    return fault(tile.step, "a tile comes outside of its step");
  }
  const TileSummary& promised = begun_->tiles[tile.index];
  if (!held_.insert(promised.digest).second) {
    return fault(tile.step, tile_name(*begun_, tile.index) + " comes, but is there already");
  }
  if (tile.payload->size() != promised.bytes) {
    return fault(tile.step, tile_name(*begun_, tile.index) + " has " +
                                std::to_string(tile.payload->size()) + " bytes; promised were " +
                                std::to_string(promised.bytes));
  }
  ++tiles_received_;
  bytes_received_ += tile.payload->size();
  if (tiles_per_decoded_ == 0 || promised.digest.low % tiles_per_decoded_ != 0) {
    return StreamProgress{};
  }
  ++tiles_decoded_;
  const auto mesh = decode_tile(*tile.payload, promised, begun_->request.lattice_resolution,
                                begun_->request.normal_bits);
  if (!mesh) {
    return fault(tile.step, tile_name(*begun_, tile.index) + " is damaged: " + mesh.error().text);
  }
  return StreamProgress{};
}

Result<StreamProgress> StreamLedger::take(const StepEnd& end) {
  if (end.request_id < open_.request_id) return StreamProgress{};
  if (end.request_id > open_.request_id) return fault(end.step, "nobody asked for its end");
  if (!begun_ || end.step != begun_->step) return fault(end.step, "it ends, but has not begun");
  const auto missing =
      std::find_if(begun_->tiles.begin(), begun_->tiles.end(),
                   [this](const TileSummary& tile) { return !held_.contains(tile.digest); });
  if (missing != begun_->tiles.end()) {
    const auto index = static_cast<std::size_t>(missing - begun_->tiles.begin());
    return fault(end.step, "it ends without " + tile_name(*begun_, index));
  }
  if (end.tiles_sent != tiles_received_ || end.payload_bytes != bytes_received_) {
    return fault(end.step, "the server counts " + std::to_string(end.tiles_sent) + " tiles and " +
                               std::to_string(end.payload_bytes) + " bytes; " +
                               std::to_string(tiles_received_) + " and " +
                               std::to_string(bytes_received_) + " came");
  }
  if (sum_of_digests(*begun_) != end.digest) {
    return fault(end.step, "the digests of its tiles do not add up to its own");
  }
  ++steps_;
  has_final_ = begun_->is_final;
  StepIsWhole whole{*std::move(begun_), end.digest};
  begun_.reset();
  return whole;
}

Result<StreamProgress> StreamLedger::take(const StreamEnd& end) {
  if (end.request_id < open_.request_id) return StreamProgress{};
  const auto reject = [](const std::string& what) {
    return fail(ErrorCode::kDamagedData, "The stream's end: " + what + ".");
  };
  if (end.request_id > open_.request_id) return reject("nobody asked for it");
  if (end.steps != steps_) return reject("it counts other steps than those that came");
  if (end.outcome == StreamOutcome::kComplete && !has_final_) {
    return reject("it says complete, but the final step is missing");
  }
  return end;
}

// ---- either

StreamChecks StreamChecks::thorough(DatasetInfo info, OpenStream open, HeldTiles held) {
  return StreamChecks(Assembler(std::move(info), std::move(open), std::move(held)), 0);
}

StreamChecks StreamChecks::cheap(DatasetInfo info, OpenStream open,
                                 std::uint32_t tiles_per_decoded) {
  return StreamChecks(StreamLedger(std::move(info), std::move(open), tiles_per_decoded),
                      tiles_per_decoded);
}

Result<StreamProgress> StreamChecks::receive(const ServerMessage& message) {
  if (auto* ledger = std::get_if<StreamLedger>(&checks_)) return ledger->receive(message);
  auto& assembler = std::get<Assembler>(checks_);
  const std::size_t before = assembler.held().size();
  const auto progress = assembler.receive(message);
  tiles_thoroughly_decoded_ += assembler.held().size() - before;
  if (!progress) return tl::unexpected(progress.error());
  if (const auto* step = std::get_if<CommittedStepPtr>(&*progress)) {
    return StepIsWhole{(*step)->begin, (*step)->end.digest};
  }
  if (const auto* end = std::get_if<StreamEnd>(&*progress)) return *end;
  if (const auto* refusal = std::get_if<Refusal>(&*progress)) return *refusal;
  return StreamProgress{};
}

StreamChecks StreamChecks::again(const DatasetInfo& info, const OpenStream& open) const {
  if (std::holds_alternative<StreamLedger>(checks_)) return cheap(info, open, tiles_per_decoded_);
  return thorough(info, open, std::get<Assembler>(checks_).held());
}

std::vector<ContentDigest> StreamChecks::held_digests() const {
  std::vector<ContentDigest> digests;
  if (const auto* ledger = std::get_if<StreamLedger>(&checks_)) {
    digests.assign(ledger->held().begin(), ledger->held().end());
  } else {
    for (const auto& [digest, mesh] : std::get<Assembler>(checks_).held())
      digests.push_back(digest);
  }
  if (digests.size() > kMaxHeldDigests) digests.resize(kMaxHeldDigests);
  return digests;
}

std::uint64_t StreamChecks::tiles_decoded() const {
  const auto* ledger = std::get_if<StreamLedger>(&checks_);
  return ledger != nullptr ? ledger->tiles_decoded() : tiles_thoroughly_decoded_;
}

}  // namespace multitetra
