// The messages of one stream, in the order the client receives them:
//
//   StepBegin, Tile and TileScalars..., StepEnd      once for each step of the plan
//   StreamEnd or ErrorReply
//
// Pure: take_request() returns the state for the next step, and the caller computes that step only
// after all messages of the previous one were taken (back-pressure). So a slow client keeps
// one encoded step in memory, never a queue. The previews of several datasets are made in
// groups, which use all threads; one group is in memory at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <set>
#include <vector>

#include "common/wire/messages.hpp"
#include "server/stream/stream_plan.hpp"

namespace multitetra {

class StreamMessages {
 public:
  // `scalars` is the range of its tiles' scalar codes, if any; `shells` allows steps of shells.
  StreamMessages(const OpenStream& open, const DatasetInfo& info,
                 std::optional<ScalarRange> scalars = {}, bool shells = false);

  [[nodiscard]] std::uint64_t request_id() const { return request_id_; }

  // Returns the state from which the next step must be computed, once for each step; nullopt while
  // messages are left, a step is being computed, or none follows.
  [[nodiscard]] std::optional<StreamState> take_request();
  // Supplies the step for the returned state, and the time it took. Ignored after end() or fail().
  void supply(StepResult step, double seconds);
  // Supplies previews of the next datasets, at least one.
  void supply(std::vector<StepResult> previews, double seconds);
  // Returns the dataset of the step that is being made: 0 is OpenStream::dataset.
  [[nodiscard]] std::size_t dataset() const { return datasets_ > 1 ? step_ : 0; }

  // End the stream: drop pending messages except the final one. Only the first call has an effect.
  void end(StreamOutcome outcome);
  void fail(Error error);

  [[nodiscard]] bool has_message() const;
  // Requires has_message(). Skips tiles that the client has or was sent in this stream, and scalars
  // of tiles for which they were sent in this stream.
  [[nodiscard]] ServerMessage take();
  [[nodiscard]] bool is_finished() const { return phase_ == Phase::kFinished; }

 private:
  enum class Phase { kWanted, kMaking, kBegin, kTiles, kLast, kFinished };

  void begin(StepResult step, double seconds);
  void begin_next_preview();
  void after_preview();
  [[nodiscard]] StepBegin step_begin() const;
  [[nodiscard]] ServerMessage next_tile_or_end();
  [[nodiscard]] std::optional<Tile> tile_to_send();
  [[nodiscard]] std::optional<TileScalars> scalars_to_send();
  void finish_with(ServerMessage last);

  std::uint64_t request_id_;
  DatasetInfo info_;
  StreamState state_;
  std::optional<ScalarRange> scalars_;
  std::set<ContentDigest> known_;  // Tiles that the client has or was sent.
  std::set<ContentDigest> known_scalars_;

  Phase phase_ = Phase::kWanted;
  std::uint32_t step_ = 0;  // The step being computed or sent.
  std::size_t datasets_ = 1;
  StepResult current_;
  // The previews of the datasets after that of current_.
  std::deque<StepResult> previews_;
  double seconds_a_preview_ = 0;
  std::size_t next_tile_ = 0;
  // The totals of the current step so far.
  StepEnd totals_;
  // Valid in phase kLast.
  ServerMessage last_;
};

}  // namespace multitetra
