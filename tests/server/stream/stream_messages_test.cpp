#include "server/stream/stream_messages.hpp"

#include <algorithm>
#include <limits>

#include <gtest/gtest.h>

#include "tests/support/fake_steps.hpp"

namespace multitetra {
namespace {

using testing::coarse_tiles;
using testing::fine_tiles;
using testing::octahedra_info;

OpenStream progressive() {
  return {.request_id = 7,
          .dataset = "octahedra",
          .request = {.isovalue = 1},
          .cached_tile_digests = {}};
}

StepResult made_step(std::vector<EncodedTile> tiles, bool is_final = false) {
  return {.step = {.request = progressive().request, .finest_spacing = is_final ? 1 : 4},
          .is_final = is_final,
          .encoded = {.tetrahedra = 100, .active_tetrahedra = 10, .tiles = std::move(tiles)},
          .after = {.request = progressive().request}};
}
StepResult empty_step(const OpenStream& open) {
  return {.step = {.request = open.request}, .is_final = true, .encoded = {}};
}

std::vector<ServerMessage> take_all(StreamMessages& stream) {
  std::vector<ServerMessage> messages;
  while (stream.has_message()) messages.push_back(stream.take());
  return messages;
}

std::size_t count_tiles(const std::vector<ServerMessage>& messages) {
  return static_cast<std::size_t>(std::count_if(
      messages.begin(), messages.end(),
      [](const ServerMessage& message) { return std::holds_alternative<Tile>(message); }));
}

TEST(StreamMessages, RequestOneStepAtATime) {
  StreamMessages stream(progressive(), octahedra_info());
  EXPECT_FALSE(stream.has_message());
  EXPECT_TRUE(stream.take_request());
  EXPECT_FALSE(stream.take_request());
  stream.supply(made_step(coarse_tiles()), 0.5);
  while (stream.has_message()) {
    EXPECT_FALSE(stream.take_request()) << "made before the step before was taken";
    (void)stream.take();
  }
  EXPECT_TRUE(stream.take_request());
}

TEST(StreamMessages, SendEverySuppliedStepThenTheEnd) {
  StreamMessages stream(progressive(), octahedra_info());
  constexpr std::uint32_t kSteps = 3;
  for (std::uint32_t i = 0; i < kSteps; ++i) {
    const auto state = stream.take_request();
    ASSERT_TRUE(state);
    EXPECT_EQ(state->request, progressive().request);
    EXPECT_EQ(state->delivered.size(), i);
    StepResult made = made_step(fine_tiles(), i + 1 == kSteps);
    made.after = *state;
    stream.supply(made, 0.25);
    const auto begin = std::get<StepBegin>(stream.take());
    EXPECT_EQ(begin.request_id, 7U);
    EXPECT_EQ(begin.step, i);
    EXPECT_EQ(begin.is_final, i + 1 == kSteps);
    EXPECT_EQ(begin.request, made.step.request);
    EXPECT_EQ(begin.finest_spacing, made.step.finest_spacing);
    EXPECT_EQ(begin.tiles.size(), 2U);
    while (i + 1 < kSteps && stream.has_message()) (void)stream.take();
  }
  const auto messages = take_all(stream);
  EXPECT_TRUE(std::holds_alternative<StepEnd>(messages[messages.size() - 2]));
  const auto& end = std::get<StreamEnd>(messages.back());
  EXPECT_EQ(end.outcome, StreamOutcome::kComplete);
  EXPECT_EQ(end.steps, kSteps);
  EXPECT_TRUE(stream.is_finished());
  EXPECT_FALSE(stream.take_request());
}

TEST(StreamMessages, SendPreviewsOfSeveralDatasetsInGroups) {
  OpenStream open = progressive();
  open.further_datasets = {"second", "third"};
  StreamMessages stream(open, octahedra_info());
  const auto group = [&](std::size_t count) {
    std::vector<StepResult> previews(count, made_step(fine_tiles()));
    stream.supply(std::move(previews), 0.5);
    return take_all(stream);
  };
  ASSERT_TRUE(stream.take_request());
  EXPECT_EQ(stream.dataset(), 0U);
  const auto first = group(2);
  EXPECT_EQ(count_tiles(first), 4U) << "each dataset has all of its own";
  EXPECT_EQ(std::get<StepBegin>(first.front()).step, 0U);
  EXPECT_EQ(std::get<StepEnd>(first.back()).step, 1U);
  EXPECT_EQ(std::get<StepEnd>(first.back()).seconds, 0.25);
  ASSERT_TRUE(stream.take_request());
  EXPECT_EQ(stream.dataset(), 2U);
  const auto last = group(1);
  const auto& end = std::get<StreamEnd>(last.back());
  EXPECT_EQ(end.outcome, StreamOutcome::kComplete);
  EXPECT_EQ(end.steps, 3U);
  EXPECT_FALSE(stream.take_request());
}

TEST(StreamMessages, DropPreviewsOfACancelledGroup) {
  OpenStream open = progressive();
  open.further_datasets = {"second"};
  StreamMessages stream(open, octahedra_info());
  (void)stream.take_request();
  std::vector<StepResult> previews(2, made_step(fine_tiles()));
  stream.supply(std::move(previews), 0);
  (void)stream.take();
  stream.end(StreamOutcome::kCancelled);
  const auto left = take_all(stream);
  ASSERT_EQ(left.size(), 1U);
  EXPECT_EQ(std::get<StreamEnd>(left[0]).steps, 0U);
}

TEST(StreamMessages, ReportDeliveredStepsWithTheirBytes) {
  StreamMessages stream(progressive(), octahedra_info());
  (void)stream.take_request();
  stream.supply(made_step(fine_tiles()), 0);
  (void)take_all(stream);
  const auto state = stream.take_request();
  ASSERT_TRUE(state);
  ASSERT_EQ(state->delivered.size(), 1U);
  EXPECT_EQ(state->delivered[0].step, made_step({}).step);
  EXPECT_EQ(state->delivered[0].size.bytes, size_of(EncodedStep{.tiles = fine_tiles()}).bytes);
}

TEST(StreamMessages, CountSentTilesAndSumDigestsInStepEnd) {
  OpenStream open = progressive();
  const auto tiles = fine_tiles();
  open.cached_tile_digests = {tiles[0].summary.digest};
  StreamMessages stream(open, octahedra_info());
  (void)stream.take_request();
  stream.supply(made_step(tiles), 0.5);
  const auto messages = take_all(stream);
  ASSERT_EQ(messages.size(), 3U);
  EXPECT_EQ(std::get<Tile>(messages[1]).index, 1U);
  const auto& end = std::get<StepEnd>(messages[2]);
  EXPECT_EQ(end.tiles_sent, 1U);
  EXPECT_EQ(end.payload_bytes, tiles[1].payload->size());
  ContentDigest sum = tiles[0].summary.digest;
  sum += tiles[1].summary.digest;
  EXPECT_EQ(end.digest, sum);
  EXPECT_EQ(end.seconds, 0.5);
}

TEST(StreamMessages, OmitTilesOfEarlierSteps) {
  StreamMessages stream(progressive(), octahedra_info());
  (void)stream.take_request();
  stream.supply(made_step(coarse_tiles()), 0);
  EXPECT_EQ(count_tiles(take_all(stream)), 2U);
  (void)stream.take_request();
  stream.supply(made_step(fine_tiles()), 0);
  EXPECT_EQ(count_tiles(take_all(stream)), 1U);
}

TEST(StreamMessages, SendEmptySurfacesAsStepsWithoutTiles) {
  OpenStream open = progressive();
  open.steps = StepPolicy::kFinalOnly;
  StreamMessages stream(open, octahedra_info());
  (void)stream.take_request();
  stream.supply(empty_step(open), 0);
  const auto messages = take_all(stream);
  ASSERT_EQ(messages.size(), 3U);
  EXPECT_TRUE(std::get<StepBegin>(messages[0]).is_final);
  EXPECT_EQ(std::get<StepEnd>(messages[1]).digest, ContentDigest{});
  EXPECT_EQ(std::get<StreamEnd>(messages[2]).steps, 1U);
}

TEST(StreamMessages, ReportBoundsInWorldUnits) {
  DatasetInfo info = octahedra_info();
  info.spacing = {3, 0.5, 1};
  OpenStream open = progressive();
  open.steps = StepPolicy::kFinalOnly;
  for (const auto& [unit, bound] : {std::pair(ErrorUnit::kVoxel, 1.0), {ErrorUnit::kWorld, 2.0}}) {
    open.request.error = 2;
    open.request.unit = unit;
    StreamMessages stream(open, info);
    (void)stream.take_request();
    stream.supply(empty_step(open), 0);
    EXPECT_EQ(std::get<StepBegin>(stream.take()).error_bound_world, bound);
  }
}

TEST(StreamMessages, ReportFiniteBoundsForHugeErrors) {
  DatasetInfo info = octahedra_info();
  info.spacing = {100, 100, 100};
  OpenStream open = progressive();
  open.steps = StepPolicy::kFinalOnly;
  open.request.error = 1e308;
  StreamMessages stream(open, info);
  (void)stream.take_request();
  stream.supply(empty_step(open), 0);
  EXPECT_EQ(std::get<StepBegin>(stream.take()).error_bound_world,
            std::numeric_limits<double>::max());
}

// Wherever a stream is stopped, exactly one message remains, and late results change nothing.
TEST(StreamMessages, SendOnlyTheEndAfterAStop) {
  for (int taken = 0; taken < 6; ++taken) {
    for (const bool fails : {false, true}) {
      SCOPED_TRACE(taken);
      StreamMessages stream(progressive(), octahedra_info());
      std::uint32_t steps_ended = 0;
      for (int i = 0; i < taken; ++i) {
        if (stream.take_request()) stream.supply(made_step(fine_tiles()), 0);
        steps_ended += std::holds_alternative<StepEnd>(stream.take()) ? 1U : 0U;
      }
      if (fails) {
        stream.fail({ErrorCode::kInternal, "..."});
      } else {
        stream.end(StreamOutcome::kCancelled);
      }
      stream.supply(made_step(fine_tiles()), 0);
      stream.end(StreamOutcome::kSuperseded);
      EXPECT_FALSE(stream.take_request());
      const auto messages = take_all(stream);
      ASSERT_EQ(messages.size(), 1U);
      EXPECT_TRUE(stream.is_finished());
      if (fails) {
        EXPECT_EQ(std::get<ErrorReply>(messages.front()).request_id, 7U);
      } else {
        const auto& end = std::get<StreamEnd>(messages.front());
        EXPECT_EQ(end.outcome, StreamOutcome::kCancelled);
        EXPECT_EQ(end.steps, steps_ended);
      }
    }
  }
}

}  // namespace
}  // namespace multitetra
