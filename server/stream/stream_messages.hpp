// The messages of one stream, one at a time, as the client takes them:
//
//   StepBegin, Tile and TileScalars..., StepEnd      once for each step of the plan
//   StreamEnd or ErrorReply
//
// Pure: wanted() returns the state for the next step, the caller makes that step, and nothing is
// made before all messages of the step before were taken (back-pressure). So a slow client holds
// one encoded step in memory, never a queue.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <vector>

#include "common/wire/messages.hpp"
#include "server/stream/stream_plan.hpp"

namespace multitetra {

class StreamMessages {
 public:
  // `scalars` is what the codes of its tiles mean, if it has any; `shells` says whether steps may
  // have them.
  StreamMessages(const OpenStream& open, const DatasetInfo& info,
                 std::optional<ScalarRange> scalars = {}, bool shells = false);

  [[nodiscard]] std::uint64_t request_id() const { return request_id_; }

  // The state of the stream when its next step must be made, returned once; nullopt while messages
  // are left, a step is being made, or none follows.
  [[nodiscard]] std::optional<StreamState> wanted();
  // The step for the returned state, and the time it took. Ignored after end() or fail().
  void supply(StepResult step, double seconds);

  // Drops messages that were not taken yet; the last one remains. The first of these two decides.
  void end(StreamOutcome outcome);
  void fail(Error error);

  [[nodiscard]] bool has_message() const;
  // Requires has_message(). Tiles that the client holds, or was sent in this stream, are left out,
  // and so are scalars of tiles that it was sent in this stream.
  [[nodiscard]] ServerMessage take();
  [[nodiscard]] bool is_finished() const { return phase_ == Phase::kFinished; }

 private:
  enum class Phase { kWanted, kMaking, kBegin, kTiles, kLast, kFinished };

  [[nodiscard]] StepBegin step_begin() const;
  [[nodiscard]] ServerMessage next_tile_or_end();
  [[nodiscard]] std::optional<Tile> tile_to_send();
  [[nodiscard]] std::optional<TileScalars> scalars_to_send();
  void finish_with(ServerMessage last);

  std::uint64_t request_id_;
  DatasetInfo info_;
  StreamState state_;
  std::optional<ScalarRange> scalars_;
  std::set<ContentDigest> known_;  // Tiles that the client has, or will have read by then.
  std::set<ContentDigest> known_scalars_;

  Phase phase_ = Phase::kWanted;
  std::uint32_t step_ = 0;  // Being made or sent.
  StepResult current_;
  std::size_t next_tile_ = 0;
  StepEnd totals_;      // For the current step so far.
  ServerMessage last_;  // Valid in phase kLast.
};

}  // namespace multitetra
