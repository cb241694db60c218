#include "client/library/assembler.hpp"

#include <functional>

#include <gtest/gtest.h>

#include "tests/support/octahedra.hpp"

namespace multitetra {
namespace {

using testing::coarse_tiles;
using testing::cube_of_half;
using testing::fine_tiles;
using testing::half_octahedron;
using testing::octahedra_info;
using testing::refined;
using testing::tile_of;

using Messages = std::vector<ServerMessage>;
using Tiles = std::vector<EncodedTile>;

constexpr std::uint64_t kId = 3;

OpenStream open_stream() {
  return {.request_id = kId,
          .dataset = "octahedra",
          .request = {.isovalue = 100.5, .error = 1},
          .cached_tile_digests = {}};
}

// ---- streams of a correct server

struct Step {
  Tiles tiles;
  double error = 1;
  double topology_tolerance = 0;
  bool is_final = true;
};

Messages messages_of(const Step& step, std::uint32_t number, std::vector<ContentDigest>& known) {
  StepBegin begin{.request_id = kId,
                  .step = number,
                  .is_final = step.is_final,
                  .request = open_stream().request,
                  .tiles = {}};
  begin.request.error = step.error;
  begin.request.topology_tolerance = step.topology_tolerance;
  StepEnd end{.request_id = kId, .step = number, .digest = {}};
  Messages tiles;
  for (const EncodedTile& tile : step.tiles) {
    begin.tiles.push_back(tile.summary);
    end.digest += tile.summary.digest;
    if (std::find(known.begin(), known.end(), tile.summary.digest) != known.end()) continue;
    known.push_back(tile.summary.digest);
    const auto index = static_cast<std::uint32_t>(begin.tiles.size() - 1);
    tiles.push_back(Tile{kId, number, index, tile.payload});
    ++end.tiles_sent;
    end.payload_bytes += tile.payload->size();
  }
  Messages messages = {begin};
  messages.insert(messages.end(), tiles.begin(), tiles.end());
  messages.push_back(end);
  return messages;
}

Messages stream_of(const std::vector<Step>& steps, std::vector<ContentDigest> known = {}) {
  Messages stream;
  for (std::uint32_t i = 0; i < steps.size(); ++i) {
    const Messages step = messages_of(steps[i], i, known);
    stream.insert(stream.end(), step.begin(), step.end());
  }
  stream.push_back(StreamEnd{.request_id = kId,
                             .outcome = StreamOutcome::kComplete,
                             .steps = static_cast<std::uint32_t>(steps.size())});
  return stream;
}

// StepBegin 0, tiles 1 and 2, StepEnd 3; StepBegin 4, one new tile 5, StepEnd 6; StreamEnd 7.
Messages two_steps() {
  return stream_of(
      {{.tiles = coarse_tiles(), .error = 4, .is_final = false}, {.tiles = fine_tiles()}});
}

// ---- the outcome of a stream

struct Outcome {
  std::vector<CommittedStepPtr> steps;
  bool is_complete = false;
  std::optional<Error> refusal;
  std::optional<Error> failed_check;
};

Outcome assemble(const Messages& messages, Assembler& assembler) {
  Outcome outcome;
  for (const ServerMessage& message : messages) {
    const auto progress = assembler.receive(message);
    if (!progress) {
      outcome.failed_check = progress.error();
      break;
    }
    if (const auto* step = std::get_if<CommittedStepPtr>(&*progress)) {
      outcome.steps.push_back(*step);
    }
    if (const auto* end = std::get_if<StreamEnd>(&*progress)) {
      outcome.is_complete = end->outcome == StreamOutcome::kComplete;
    }
    if (const auto* refusal = std::get_if<Refusal>(&*progress)) outcome.refusal = refusal->error;
  }
  return outcome;
}

Outcome assemble(const Messages& messages) {
  Assembler assembler(octahedra_info(), open_stream());
  return assemble(messages, assembler);
}

void expect_fault(const Messages& messages, const std::string& words) {
  const Outcome outcome = assemble(messages);
  ASSERT_TRUE(outcome.failed_check) << "nothing was found, expected: " << words;
  EXPECT_EQ(outcome.failed_check->code, ErrorCode::kDamagedData);
  EXPECT_NE(outcome.failed_check->text.find(words), std::string::npos)
      << outcome.failed_check->text;
  EXPECT_FALSE(outcome.is_complete);
}

template <typename M>
M& at(Messages& messages, std::size_t index) {
  return std::get<M>(messages.at(index));
}

// ---- valid streams

TEST(Assembler, ReturnsEachStepOnceCompleteAndChecked) {
  const Outcome outcome = assemble(two_steps());
  ASSERT_FALSE(outcome.failed_check) << outcome.failed_check->text;
  ASSERT_EQ(outcome.steps.size(), 2U);
  EXPECT_TRUE(outcome.is_complete);
  EXPECT_EQ(outcome.steps[0]->topology.triangles, 8);
  EXPECT_EQ(outcome.steps[0]->topology.vertices, 6);
  EXPECT_EQ(outcome.steps[1]->topology.triangles, 10);
  EXPECT_EQ(outcome.steps[1]->topology.vertices, 7);
  for (const auto& step : outcome.steps) {
    EXPECT_EQ(step->topology.euler_characteristic, 2);
    EXPECT_EQ(step->topology.components, 1);
    EXPECT_TRUE(step->topology.is_sound());
    EXPECT_EQ(digest(step->mesh), step->end.digest);
  }
}

TEST(Assembler, ShowsThePreviousStepUntilTheNextIsComplete) {
  const Messages stream = two_steps();
  Assembler assembler(octahedra_info(), open_stream());
  for (std::size_t i = 0; i < stream.size(); ++i) {
    ASSERT_TRUE(assembler.receive(stream[i]));
    const auto& shown = assembler.shown();
    ASSERT_EQ(shown != nullptr, i >= 3);
    if (shown) {
      EXPECT_EQ(shown->begin.step, i < 6 ? 0U : 1U);
    }
  }
}

TEST(Assembler, AcceptsTilesInAnyOrder) {
  Messages stream = two_steps();
  std::swap(stream[1], stream[2]);
  EXPECT_TRUE(assemble(stream).is_complete);
}

TEST(Assembler, AcceptsEmptySurfacesAsSteps) {
  const Outcome outcome = assemble(stream_of({{.tiles = {}}}));
  EXPECT_TRUE(outcome.is_complete);
  ASSERT_EQ(outcome.steps.size(), 1U);
  EXPECT_EQ(outcome.steps[0]->topology.triangles, 0);
}

TEST(Assembler, ContinuesAfterALostConnectionWithTheTilesItHolds) {
  Assembler first(octahedra_info(), open_stream());
  Messages broken_off = two_steps();
  broken_off.resize(2);
  EXPECT_TRUE(assemble(broken_off, first).steps.empty());
  ASSERT_EQ(first.held().size(), 1U);

  std::vector<ContentDigest> known;
  for (const auto& [digest, mesh] : first.held()) known.push_back(digest);
  OpenStream open = open_stream();
  open.cached_tile_digests = known;
  Assembler second(octahedra_info(), open, first.held());
  const Messages rest = stream_of({{.tiles = fine_tiles()}}, known);
  EXPECT_EQ(rest.size(), 4U) << "one of two tiles is sent";
  const Outcome outcome = assemble(rest, second);
  EXPECT_TRUE(outcome.is_complete);
  EXPECT_EQ(outcome.steps.back()->topology.triangles, 10);
}

// The protocol limits requests to 8192 digests; a client with more tiles receives the others again.
TEST(Assembler, AcceptsUnannouncedHeldTiles) {
  Assembler first(octahedra_info(), open_stream());
  ASSERT_TRUE(assemble(two_steps(), first).is_complete);
  ASSERT_EQ(first.held().size(), 3U);
  OpenStream open = open_stream();
  open.cached_tile_digests = {coarse_tiles()[0].summary.digest};
  Assembler second(octahedra_info(), open, first.held());
  const Outcome outcome =
      assemble(stream_of({{.tiles = fine_tiles()}}, open.cached_tile_digests), second);
  ASSERT_FALSE(outcome.failed_check) << outcome.failed_check->text;
  EXPECT_EQ(outcome.steps.back()->end.tiles_sent, 1U);
}

TEST(Assembler, IgnoresMessagesOfAnEarlierStream) {
  Messages late = two_steps();
  for (ServerMessage& message : late) {
    std::visit(
        [](auto& m) {
          if constexpr (requires { m.request_id; }) m.request_id = kId - 1;
        },
        message);
  }
  late.push_back(ErrorReply{kId - 1, {ErrorCode::kInternal, "..."}});
  const Messages stream = two_steps();
  for (std::size_t split = 0; split <= stream.size(); ++split) {
    Messages mixed(stream.begin(), stream.begin() + static_cast<std::ptrdiff_t>(split));
    mixed.insert(mixed.end(), late.begin(), late.end());
    mixed.insert(mixed.end(), stream.begin() + static_cast<std::ptrdiff_t>(split), stream.end());
    const Outcome outcome = assemble(mixed);
    EXPECT_TRUE(outcome.is_complete) << split;
    EXPECT_EQ(outcome.steps.size(), 2U);
  }
}

TEST(Assembler, KeepsTheShownStepWhenCancelled) {
  const Messages stream = two_steps();
  for (std::size_t taken = 0; taken < 7; ++taken) {
    Assembler assembler(octahedra_info(), open_stream());
    Messages cut(stream.begin(), stream.begin() + static_cast<std::ptrdiff_t>(taken));
    const std::uint32_t ended = taken > 3 ? 1 : 0;
    cut.push_back(StreamEnd{kId, StreamOutcome::kCancelled, ended});
    const Outcome outcome = assemble(cut, assembler);
    EXPECT_FALSE(outcome.failed_check);
    EXPECT_EQ(outcome.steps.size(), ended);
    EXPECT_EQ(assembler.shown() != nullptr, ended == 1);
  }
}

TEST(Assembler, ReportsARejectionWithoutAFailedCheck) {
  const Outcome outcome = assemble({ErrorReply{kId, {ErrorCode::kInvalidArgument, "..."}}});
  EXPECT_FALSE(outcome.failed_check);
  ASSERT_TRUE(outcome.refusal);
  EXPECT_EQ(outcome.refusal->code, ErrorCode::kInvalidArgument);
}

// ---- messages lost, repeated, or out of order

TEST(Assembler, DetectsAnyLostMessage) {
  const Messages stream = two_steps();
  for (std::size_t lost = 0; lost < stream.size(); ++lost) {
    Messages damaged = stream;
    damaged.erase(damaged.begin() + static_cast<std::ptrdiff_t>(lost));
    EXPECT_FALSE(assemble(damaged).is_complete) << "without message " << lost;
  }
}

TEST(Assembler, RejectsRepeatedMessages) {
  const Messages stream = two_steps();
  for (std::size_t twice = 0; twice < stream.size(); ++twice) {
    Messages damaged = stream;
    damaged.insert(damaged.begin() + static_cast<std::ptrdiff_t>(twice), stream[twice]);
    EXPECT_TRUE(assemble(damaged).failed_check) << "message " << twice << " twice";
  }
}

TEST(Assembler, StaysFailedAfterAFailedCheck) {
  Messages stream = two_steps();
  Assembler assembler(octahedra_info(), open_stream());
  EXPECT_FALSE(assembler.receive(stream[1]));
  for (const ServerMessage& message : stream) EXPECT_FALSE(assembler.receive(message));
  EXPECT_EQ(assembler.shown(), nullptr);
}

TEST(Assembler, RejectsAStepEndWithMissingTiles) {
  Messages stream = two_steps();
  stream.erase(stream.begin() + 2);
  expect_fault(stream, "without tile 1 (cube 4:1/0/0)");
}

TEST(Assembler, RejectsATileSentTwice) {
  Messages stream = two_steps();
  stream.insert(stream.begin() + 2, stream[1]);
  expect_fault(stream, "tile 0 (cube 4:0/0/0) was sent again");
}

TEST(Assembler, RejectsTilesAnnouncedAsHeld) {
  Messages stream = two_steps();
  stream.insert(stream.begin() + 5, Tile{kId, 1, 0, coarse_tiles()[0].payload});
  expect_fault(stream, "tile 0 (cube 4:0/0/0) was sent again");
}

TEST(Assembler, RejectsTilesMissingFromTheManifest) {
  Messages stream = two_steps();
  at<Tile>(stream, 1).index = 2;
  expect_fault(stream, "tile 2 was sent, but the number of tiles is 2");
}

TEST(Assembler, RejectsStepsOfOtherNumbers) {
  Messages stream = two_steps();  // Steps 0 and 2.
  at<StepBegin>(stream, 4).step = 2;
  at<Tile>(stream, 5).step = 2;
  at<StepEnd>(stream, 6).step = 2;
  expect_fault(stream, "step 1 was expected");
}

TEST(Assembler, RejectsMessagesOfUnknownRequests) {
  for (const std::size_t index : {0U, 1U, 3U, 7U}) {
    Messages stream = two_steps();
    std::visit(
        [](auto& m) {
          if constexpr (requires { m.request_id; }) m.request_id = kId + 1;
        },
        stream[index]);
    EXPECT_TRUE(assemble(stream).failed_check) << index;
  }
}

// ---- damaged contents

TEST(Assembler, DetectsAnyChangedPayloadByte) {
  const Messages stream = two_steps();
  const std::string payload = *std::get<Tile>(stream[1]).payload;
  for (std::size_t byte = 0; byte < payload.size(); ++byte) {
    Messages damaged = stream;
    std::string changed = payload;
    changed[byte] = static_cast<char>(changed[byte] ^ 0x55);
    at<Tile>(damaged, 1).payload = std::make_shared<const std::string>(changed);
    const Outcome outcome = assemble(damaged);
    // A byte that Draco ignores may change; then the surface is identical.
    if (outcome.failed_check) {
      EXPECT_NE(outcome.failed_check->text.find("tile 0"), std::string::npos);
    } else {
      EXPECT_TRUE(outcome.is_complete);
    }
  }
}

TEST(Assembler, RejectsTilesWhoseCountsOrDigestsDifferFromTheManifest) {
  const std::vector<std::pair<std::string, std::function<void(TileSummary&)>>> lies = {
      {"tile 0", [](TileSummary& t) { ++t.triangles; }},
      {"tile 0", [](TileSummary& t) { ++t.vertices; }},
      {"bytes; the manifest lists", [](TileSummary& t) { ++t.bytes; }},
      {"tile 0", [](TileSummary& t) { ++t.digest.low; }},
      {"tile 0", [](TileSummary& t) { t.cube.exponent = 3; }},
      {"outside the grid", [](TileSummary& t) { t.cube.exponent = 6; }},
      {"outside the grid", [](TileSummary& t) { t.cube.x = 2; }}};
  for (const auto& [words, lie] : lies) {
    Messages stream = two_steps();
    lie(at<StepBegin>(stream, 0).tiles[0]);
    expect_fault(stream, words);
  }
}

TEST(Assembler, RejectsHeldTilesThatDifferFromTheManifest) {
  Assembler first(octahedra_info(), open_stream());
  ASSERT_TRUE(assemble(two_steps(), first).is_complete);
  OpenStream open = open_stream();
  for (const EncodedTile& tile : fine_tiles()) {
    open.cached_tile_digests.push_back(tile.summary.digest);
  }
  const std::vector<std::function<void(TileSummary&)>> lies = {
      [](TileSummary& t) { ++t.triangles; }, [](TileSummary& t) { ++t.vertices; },
      [](TileSummary& t) { t.cube.exponent = 3; }};
  for (const auto& lie : lies) {
    Messages stream = stream_of({{.tiles = fine_tiles()}}, open.cached_tile_digests);
    lie(at<StepBegin>(stream, 0).tiles[0]);
    Assembler second(octahedra_info(), open, first.held());
    const Outcome outcome = assemble(stream, second);
    ASSERT_TRUE(outcome.failed_check);
    EXPECT_NE(outcome.failed_check->text.find("is already held, but"), std::string::npos)
        << outcome.failed_check->text;
  }
}

TEST(Assembler, RejectsManifestsThatRepeatATile) {
  Messages stream = two_steps();
  auto& begin = at<StepBegin>(stream, 0);
  begin.tiles[1].cube = begin.tiles[0].cube;
  expect_fault(stream, "is listed twice");
  stream = two_steps();
  auto& same = at<StepBegin>(stream, 0);
  same.tiles[1].digest = same.tiles[0].digest;
  expect_fault(stream, "same content");
}

TEST(Assembler, RejectsStepTotalsThatDifferFromTheTiles) {
  Messages stream = two_steps();
  ++at<StepEnd>(stream, 3).tiles_sent;
  expect_fault(stream, "the server counts 3 tiles");
  stream = two_steps();
  ++at<StepEnd>(stream, 3).payload_bytes;
  expect_fault(stream, "the server counts 2 tiles");
  stream = two_steps();
  ++at<StepEnd>(stream, 3).digest.high;
  expect_fault(stream, "its digest is");
  stream = two_steps();
  ++at<StreamEnd>(stream, 7).steps;
  expect_fault(stream, "the server counts 3 steps");
}

// 32-bit counts alone allocate nothing before the tiles arrive.
TEST(Assembler, RejectsManifestsBeyondTheLimitsAtOnce) {
  const auto refused = [](AssemblerLimits limits) {
    Assembler assembler(octahedra_info(), open_stream(), {}, limits);
    return !assembler.receive(two_steps()[0]).has_value();
  };
  EXPECT_FALSE(refused({.tiles = 2, .triangles = 8}));
  EXPECT_TRUE(refused({.tiles = 1}));
  EXPECT_TRUE(refused({.triangles = 7}));
  EXPECT_TRUE(refused({.payload_bytes = 10}));
}

TEST(Assembler, LimitsTheStepsOfAStream) {
  const auto previews = [](std::size_t count) {
    return stream_of(
        std::vector<Step>(count, {.tiles = coarse_tiles(), .error = 4, .is_final = false}));
  };
  for (const std::size_t count : {3U, 4U}) {
    Assembler assembler(octahedra_info(), open_stream(), {}, {.steps = 3});
    Messages stream = previews(count);
    stream.pop_back();
    const Outcome outcome = assemble(stream, assembler);
    EXPECT_EQ(outcome.steps.size(), 3U);
    EXPECT_EQ(outcome.failed_check.has_value(), count > 3);
  }
  EXPECT_TRUE(assemble(previews(AssemblerLimits{}.steps + 1)).failed_check);
}

// Tiles are kept for later steps, so the limits are per stream; a tile in both steps counts once.
TEST(Assembler, LimitsTheTotalOfAllSteps) {
  const auto limited = [](AssemblerLimits limits) {
    Assembler assembler(octahedra_info(), open_stream(), {}, limits);
    return assemble(two_steps(), assembler);
  };
  const std::uint64_t bytes = coarse_tiles()[0].payload->size() +
                              coarse_tiles()[1].payload->size() + fine_tiles()[1].payload->size();
  EXPECT_TRUE(limited({.tiles = 3, .triangles = 14, .payload_bytes = bytes}).is_complete);
  for (const AssemblerLimits& limits :
       {AssemblerLimits{.tiles = 2}, {.triangles = 13}, {.payload_bytes = bytes - 1}}) {
    const Outcome outcome = limited(limits);
    EXPECT_EQ(outcome.steps.size(), 1U);
    ASSERT_TRUE(outcome.failed_check);
    EXPECT_NE(outcome.failed_check->text.find("Step 1: with the previous steps"), std::string::npos)
        << outcome.failed_check->text;
  }
}

// ---- steps that differ from the request

TEST(Assembler, RejectsFinalStepsThatDifferFromTheRequest) {
  const std::vector<std::function<void(StepBegin&)>> lies = {
      [](StepBegin& b) { b.request.error = 2; }, [](StepBegin& b) { b.request.isovalue = 101; },
      [](StepBegin& b) { b.request.error_measure = ErrorMeasure::kPaper; },
      [](StepBegin& b) { b.request.topology_tolerance = 1; },
      [](StepBegin& b) { b.finest_spacing = 2; }};
  for (const auto& lie : lies) {
    Messages stream = two_steps();
    lie(at<StepBegin>(stream, 4));
    expect_fault(stream, "final step");
  }
}

TEST(Assembler, RejectsPreviewsThatDifferInMoreThanAccuracy) {
  const std::vector<std::function<void(StepBegin&)>> lies = {
      [](StepBegin& b) { b.request.error = 0.5; }, [](StepBegin& b) { b.request.isovalue = 101; },
      [](StepBegin& b) { b.request.unit = ErrorUnit::kWorld; },
      [](StepBegin& b) { b.request.lattice_resolution = 6; }, [](StepBegin& b) { b.step = 1; }};
  for (const auto& lie : lies) {
    Messages stream = two_steps();
    lie(at<StepBegin>(stream, 0));
    EXPECT_TRUE(assemble(stream).failed_check);
  }
}

TEST(Assembler, RejectsStepsAfterTheFinalOne) {
  expect_fault(stream_of({{.tiles = coarse_tiles()}, {.tiles = fine_tiles()}}),
               "it follows the final step");
}

// ---- torn surfaces of valid tiles

TEST(Assembler, DetectsACrackBetweenTiles) {
  auto moved = half_octahedron(1);
  for (LatticeTriangle& triangle : moved) {
    for (LatticePoint& p : triangle) {
      if (p.x == 512) p.y += 1;  // One lattice step along the border.
    }
  }
  const Tiles torn = {coarse_tiles()[0], tile_of(moved, cube_of_half(1))};
  expect_fault(stream_of({{.tiles = torn}}), "8 open edges");
}

TEST(Assembler, DetectsAMissingTileThatTheManifestOmits) {
  expect_fault(stream_of({{.tiles = {coarse_tiles()[0]}}}), "the mesh has defects: 4 open edges");
}

TEST(Assembler, DetectsFlippedTriangles) {
  auto turned = half_octahedron(1);
  for (LatticeTriangle& triangle : turned) std::swap(triangle[1], triangle[2]);
  const Tiles folded = {coarse_tiles()[0], tile_of(turned, cube_of_half(1))};
  expect_fault(stream_of({{.tiles = folded}}), "4 non-manifold edges");
}

// Adds a second, distant component in a tile of its own.
Tiles with_a_second_component(Tiles tiles) {
  auto far_away = half_octahedron(-1);
  for (const LatticeTriangle& triangle : half_octahedron(1)) far_away.push_back(triangle);
  for (LatticeTriangle& triangle : far_away) {
    for (LatticePoint& p : triangle) p.x -= 256, p.y += 512;
  }
  tiles.push_back(tile_of(far_away, {.exponent = 4, .x = 0, .y = 1, .z = 0}));
  return tiles;
}

TEST(Assembler, RejectsTopologyPreservingStepsThatDisagreeOnTheTopology) {
  expect_fault(
      stream_of({{.tiles = with_a_second_component(coarse_tiles()), .error = 4, .is_final = false},
                 {.tiles = fine_tiles()}}),
      "its topology differs from step 0");
}

TEST(Assembler, AllowsTolerantPreviewsAnotherTopology) {
  EXPECT_TRUE(assemble(stream_of({{.tiles = with_a_second_component(coarse_tiles()),
                                   .error = 4,
                                   .topology_tolerance = 4,
                                   .is_final = false},
                                  {.tiles = fine_tiles()}}))
                  .is_complete);
}

// Each of three datasets, of which the first two have the same surface, brings all of its tiles.
Messages previews_of_several(bool is_final = false) {
  Messages stream;
  std::uint32_t number = 0;
  for (const Tiles& tiles : {fine_tiles(), fine_tiles(), coarse_tiles()}) {
    std::vector<ContentDigest> known;
    const Messages step =
        messages_of({.tiles = tiles, .error = 4, .is_final = is_final}, number++, known);
    stream.insert(stream.end(), step.begin(), step.end());
  }
  stream.push_back(
      StreamEnd{.request_id = kId, .outcome = StreamOutcome::kComplete, .steps = number});
  return stream;
}

TEST(Assembler, ReturnsPreviewsOfSeveralDatasetsInOrder) {
  OpenStream open = open_stream();
  open.steps = StepPolicy::kPreviewsOnly;
  open.resumed_previews = {{.finest_spacing = 1, .is_unsimplified = true}};
  open.further_datasets = {"second", "third"};
  const auto outcome_of = [&](const Messages& messages) {
    Assembler assembler(octahedra_info(), open);
    return assemble(messages, assembler);
  };
  const Messages good = previews_of_several();
  const Outcome all = outcome_of(good);
  EXPECT_FALSE(all.failed_check) << all.failed_check->text;
  EXPECT_EQ(all.steps.size(), 3U);
  EXPECT_TRUE(all.is_complete);
  EXPECT_TRUE(outcome_of(previews_of_several(true)).failed_check);
  Messages short_of_one(good.begin(), good.begin() + 8);  // Two steps.
  ASSERT_TRUE(std::holds_alternative<StepEnd>(short_of_one.back()));
  short_of_one.push_back(
      StreamEnd{.request_id = kId, .outcome = StreamOutcome::kComplete, .steps = 2});
  EXPECT_TRUE(outcome_of(short_of_one).failed_check);
}

}  // namespace
}  // namespace multitetra
