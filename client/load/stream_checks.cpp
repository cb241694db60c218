#include "client/load/stream_checks.hpp"

namespace multitetra {

StreamChecks StreamChecks::thorough(DatasetInfo info, OpenStream open, CachedTiles held) {
  return StreamChecks(Assembler(std::move(info), std::move(open), std::move(held)), 0);
}

StreamChecks StreamChecks::cheap(DatasetInfo info, OpenStream open,
                                 std::uint32_t tiles_per_decoded) {
  std::set<ContentDigest> held(open.cached_tile_digests.begin(), open.cached_tile_digests.end());
  return StreamChecks(StreamValidator(std::move(info), std::move(open), std::move(held)),
                      tiles_per_decoded);
}

Result<StreamProgress> StreamChecks::receive(const ServerMessage& message) {
  return std::visit([&](auto& checks) { return receive(checks, message); }, checks_);
}

Result<StreamProgress> StreamChecks::receive(StreamValidator& validator,
                                             const ServerMessage& message) {
  const auto accepted = validator.accept(message);
  if (!accepted) return tl::unexpected(accepted.error());
  if (!*accepted) return StreamProgress{};
  if (const auto* end = std::get_if<StepEnd>(&message)) {
    return WholeStep{validator.step(), end->digest};
  }
  if (const auto* end = std::get_if<StreamEnd>(&message)) return *end;
  if (const auto* reply = std::get_if<ErrorReply>(&message)) return Refusal{reply->error};
  const auto* tile = std::get_if<Tile>(&message);
  if (tile == nullptr || tiles_per_decoded_ == 0) return StreamProgress{};
  const TileSummary& promised = validator.step().tiles[tile->index];
  if (promised.digest.low % tiles_per_decoded_ != 0) return StreamProgress{};
  ++tiles_decoded_;
  const IsosurfaceRequest& request = validator.step().request;
  const auto mesh =
      decode_tile(*tile->payload, promised, request.lattice_resolution, request.normal_bits);
  if (!mesh) return fail(ErrorCode::kDamagedData, "A tile is damaged: " + mesh.error().text);
  return StreamProgress{};
}

Result<StreamProgress> StreamChecks::receive(Assembler& assembler, const ServerMessage& message) {
  const std::size_t before = assembler.held().size();
  const auto progress = assembler.receive(message);
  tiles_decoded_ += assembler.held().size() - before;
  if (!progress) return tl::unexpected(progress.error());
  if (const auto* step = std::get_if<CommittedStepPtr>(&*progress)) {
    return WholeStep{(*step)->begin, (*step)->end.digest};
  }
  if (const auto* end = std::get_if<StreamEnd>(&*progress)) return *end;
  if (const auto* refusal = std::get_if<Refusal>(&*progress)) return *refusal;
  return StreamProgress{};
}

StreamChecks StreamChecks::resumed(const DatasetInfo& info, const OpenStream& open) const {
  if (!is_thorough()) return cheap(info, open, tiles_per_decoded_);
  return thorough(info, open, std::get<Assembler>(checks_).held());
}

std::vector<ContentDigest> StreamChecks::held_digests() const {
  std::vector<ContentDigest> digests;
  if (const auto* validator = std::get_if<StreamValidator>(&checks_)) {
    digests.assign(validator->held().begin(), validator->held().end());
  } else {
    for (const auto& [digest, mesh] : std::get<Assembler>(checks_).held())
      digests.push_back(digest);
  }
  if (digests.size() > kMaxHeldDigests) digests.resize(kMaxHeldDigests);
  return digests;
}

}  // namespace multitetra
