// A viewer that changes its request before the surface is complete.
#include "client/library/surface_stream.hpp"

#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "tests/support/fake_steps.hpp"
#include "tests/support/fields.hpp"
#include "tests/support/running_server.hpp"
#include "tests/support/served_datasets.hpp"

namespace multitetra {
namespace {

using std::chrono::milliseconds;
using testing::extracted_digest;
using testing::RunningServer;

DatasetPtr gyroid_dataset() { return make_dataset(testing::fields::gyroid(72, 0.3, 7), "gyroid"); }

class SurfaceStreamTest : public ::testing::Test {
 protected:
  [[nodiscard]] Client connected() const {
    auto client = Client::connect(server_.endpoint(), {});
    if (!client) throw std::runtime_error(client.error().error.text);
    return *std::move(client);
  }
  [[nodiscard]] OpenStream at(double isovalue, StepPolicy steps = StepPolicy::kProgressive) const {
    return {.dataset = "gyroid",
            .request = {.isovalue = isovalue, .error = 0.25},
            .steps = steps,
            .cached_tile_digests = {}};
  }
  // Runs the stream to its end and returns its outcome.
  static StreamOutcome finish(SurfaceStream& stream, std::vector<FetchedStep>* steps = nullptr) {
    for (;;) {
      const auto news = stream.next(std::chrono::seconds(30));
      if (!news) throw std::runtime_error(news.error().error.text);
      if (const auto* end = std::get_if<StreamEnded>(&*news)) return end->outcome;
      const auto* step = std::get_if<FetchedStep>(&*news);
      if (step != nullptr && steps != nullptr) steps->push_back(*step);
    }
  }

  DatasetPtr dataset_ = gyroid_dataset();
  const DatasetInfo& info_ = dataset_->info;
  RunningServer server_{testing::catalogue_with({dataset_})};
};

TEST_F(SurfaceStreamTest, ShowsEveryStepUntilTheNext) {
  Client client = connected();
  DecodedTileCache tiles;
  SurfaceStream stream(client, tiles);
  EXPECT_EQ(stream.shown(), nullptr);
  EXPECT_FALSE(stream.is_running());
  ASSERT_TRUE(stream.open(info_, at(0.1)));
  CommittedStepPtr shown;
  while (stream.is_running()) {
    const auto news = stream.next(milliseconds(1));
    ASSERT_TRUE(news) << news.error().error.text;
    const auto* step = std::get_if<FetchedStep>(&*news);
    if (step != nullptr) shown = step->step;
    EXPECT_EQ(stream.shown(), shown) << "it changes with a step and not otherwise";
  }
  ASSERT_TRUE(shown);
  EXPECT_TRUE(shown->begin.is_final);
  EXPECT_EQ(shown->end.digest, extracted_digest(dataset_, {.request = at(0.1).request}));
}

TEST_F(SurfaceStreamTest, ReceivesOneMessageAtATimeWithZeroTimeout) {
  Client client = connected();
  DecodedTileCache tiles;
  SurfaceStream stream(client, tiles);
  ASSERT_TRUE(stream.open(info_, at(0.1, StepPolicy::kFinalOnly)));
  std::uint64_t before = 0;
  while (stream.is_running()) {
    ASSERT_TRUE(stream.next(milliseconds(0)));
    EXPECT_LE(stream.received().tiles, before + 1);
    before = stream.received().tiles;
  }
  EXPECT_GT(before, 3U);
}

TEST_F(SurfaceStreamTest, StopsTheOldRequestForANewOne) {
  Client client = connected();
  DecodedTileCache tiles;
  SurfaceStream stream(client, tiles);
  const ContentDigest wanted = extracted_digest(dataset_, {.request = at(0.2).request});
  for (int wait = 0; wait < 12; ++wait) {
    ASSERT_TRUE(stream.open(info_, at(-0.3 + 0.01 * wait)));
    const auto news = stream.next(milliseconds(2 * wait));
    ASSERT_TRUE(news) << news.error().error.text;
    const CommittedStepPtr before = stream.shown();
    ASSERT_TRUE(stream.open(info_, at(0.2)));
    EXPECT_EQ(stream.shown(), before) << "it stays until the new request has a step";
    EXPECT_EQ(finish(stream), StreamOutcome::kComplete);
    EXPECT_EQ(stream.shown()->end.digest, wanted);
  }
}

TEST_F(SurfaceStreamTest, KeepsTheShownStepOnCancel) {
  Client client = connected();
  DecodedTileCache tiles;
  SurfaceStream stream(client, tiles);
  ASSERT_TRUE(stream.open(info_, at(0.1)));
  EXPECT_EQ(finish(stream), StreamOutcome::kComplete);
  const CommittedStepPtr before = stream.shown();
  ASSERT_TRUE(stream.open(info_, at(0.3)));
  ASSERT_TRUE(stream.cancel());
  finish(stream);
  EXPECT_FALSE(stream.is_running());
  EXPECT_TRUE(stream.shown() == before || stream.shown()->begin.request.isovalue == 0.3);
  ASSERT_TRUE(stream.cancel()) << "there is nothing to cancel any more";
  ASSERT_TRUE(stream.open(info_, at(0.3)));
  EXPECT_EQ(finish(stream), StreamOutcome::kComplete);
  EXPECT_EQ(stream.shown()->end.digest, extracted_digest(dataset_, {.request = at(0.3).request}));
}

TEST_F(SurfaceStreamTest, ReusesTilesOfEarlierRequests) {
  Client client = connected();
  DecodedTileCache tiles;
  SurfaceStream stream(client, tiles);
  ASSERT_TRUE(stream.open(info_, at(0.1)));
  finish(stream);
  const std::uint64_t received = stream.received().tiles;
  ASSERT_TRUE(stream.open(info_, at(0.1, StepPolicy::kFinalOnly)));
  std::vector<FetchedStep> steps;
  finish(stream, &steps);
  EXPECT_EQ(steps.size(), 1U) << "a new request gets its step";
  EXPECT_EQ(stream.received().tiles, received);
}

TEST_F(SurfaceStreamTest, KeepsSurfaceAndConnectionAfterARejectedRequest) {
  Client client = connected();
  DecodedTileCache tiles;
  SurfaceStream stream(client, tiles);
  ASSERT_TRUE(stream.open(info_, at(0.1)));
  finish(stream);
  const CommittedStepPtr before = stream.shown();
  ASSERT_TRUE(stream.open(info_, {.dataset = "nowhere", .request = {}, .cached_tile_digests = {}}));
  const auto news = stream.next(std::chrono::seconds(30));
  ASSERT_FALSE(news);
  EXPECT_EQ(news.error().error.code, ErrorCode::kUnknownDataset);
  EXPECT_EQ(stream.shown(), before);
  ASSERT_TRUE(stream.open(info_, at(0.2)));
  EXPECT_EQ(finish(stream), StreamOutcome::kComplete);
}

// A user drags a slider: a hundred isovalues, about thirty per second.
TEST_F(SurfaceStreamTest, EndsADragThroughAHundredIsovaluesWithTheLastInBoundedMemory) {
  constexpr TileMemoryLimits kLimits = {.tiles = 24, .triangles = 100'000};
  Client client = connected();
  DecodedTileCache tiles(kLimits);
  SurfaceStream stream(client, tiles);
  std::set<double> shown;
  double isovalue = 0;
  for (int i = 0; i < 100; ++i) {
    isovalue = -0.5 + 0.01 * i;
    ASSERT_TRUE(stream.open(info_, at(isovalue)));
    const auto until = std::chrono::steady_clock::now() + milliseconds(33);
    // Every tenth isovalue waits until a surface is shown, however slow the machine is.
    bool is_waiting = i % 10 == 9;
    while ((is_waiting || std::chrono::steady_clock::now() < until) && stream.is_running()) {
      const auto news = stream.next(milliseconds(5));
      ASSERT_TRUE(news) << news.error().error.text;
      if (const auto* step = std::get_if<FetchedStep>(&*news)) {
        is_waiting = false;
        shown.insert(step->step->begin.request.isovalue);
        EXPECT_EQ(step->step->begin.request.isovalue, isovalue) << "never an older request's";
      }
      ASSERT_LE(tiles.triangles(), kLimits.triangles);
      ASSERT_LE(tiles.size(), kLimits.tiles);
    }
  }
  EXPECT_EQ(finish(stream), StreamOutcome::kComplete);
  EXPECT_EQ(stream.shown()->begin.request.isovalue, isovalue);
  EXPECT_EQ(stream.shown()->end.digest,
            extracted_digest(dataset_, {.request = at(isovalue).request}));
  shown.insert(isovalue);
  EXPECT_GE(shown.size(), 5U) << "previews are seen on the way";
  EXPECT_GT(stream.received().tiles, kLimits.tiles) << "more came than the memory may hold";
}

TEST_F(SurfaceStreamTest, EndsAStreamToDisplayWithShellsOfTheRequestedTopology) {
  Client client = connected();
  DecodedTileCache tiles;
  SurfaceStream stream(client, tiles);
  OpenStream to_keep = at(0.1);
  to_keep.request.simplify = true;
  ASSERT_TRUE(stream.open(info_, to_keep));
  std::vector<FetchedStep> kept;
  EXPECT_EQ(finish(stream, &kept), StreamOutcome::kComplete);
  EXPECT_FALSE(kept.back().step->begin.shell) << "a mesh to be kept is the request itself";
  EXPECT_TRUE(kept.front().step->begin.shell) << "its previews may be shells";
  OpenStream to_display = to_keep;
  to_display.use = MeshUse::kDisplay;
  std::vector<FetchedStep> displayed;
  ASSERT_TRUE(stream.open(info_, to_display));
  EXPECT_EQ(finish(stream, &displayed), StreamOutcome::kComplete);
  const CommittedStep& last = *displayed.back().step;
  EXPECT_TRUE(last.begin.is_final);
  ASSERT_TRUE(last.begin.shell);
  EXPECT_EQ(last.begin.finest_spacing, 1);
  EXPECT_LE(last.begin.error_bound_world, 0.25);
  EXPECT_EQ(last.topology.euler_characteristic, kept.back().step->topology.euler_characteristic);
  EXPECT_EQ(last.topology.components, kept.back().step->topology.components);
  // All tiles are cached: none is sent again.
  const std::uint64_t received = stream.received().tiles;
  to_display.steps = StepPolicy::kFinalOnly;
  ASSERT_TRUE(stream.open(info_, to_display));
  displayed.clear();
  EXPECT_EQ(finish(stream, &displayed), StreamOutcome::kComplete);
  EXPECT_EQ(displayed.back().step->end.digest, last.end.digest);
  EXPECT_EQ(stream.received().tiles, received);
}

TEST_F(SurfaceStreamTest, ReceivesNoShellsUnlessDecoded) {
  auto client = Client::connect(server_.endpoint(), {.codecs = {PayloadCodec::kDracoLattice}});
  ASSERT_TRUE(client);
  DecodedTileCache tiles;
  SurfaceStream stream(*client, tiles);
  OpenStream open = at(0.1);
  open.use = MeshUse::kDisplay;
  ASSERT_TRUE(stream.open(info_, open));
  std::vector<FetchedStep> steps;
  EXPECT_EQ(finish(stream, &steps), StreamOutcome::kComplete);
  for (const FetchedStep& step : steps) EXPECT_FALSE(step.step->begin.shell);
}

// Making a step takes several timeouts.
TEST(SurfaceStreamRetries, RetryUntilAccepted) {
  using testing::FakeSteps;
  const RunningServer server(testing::catalogue_of(
      std::make_shared<FakeSteps>("fake", [](const StepRequest& step, const std::stop_token&) {
        std::this_thread::sleep_for(milliseconds(2500));
        return testing::octahedron_step(step);
      })));
  auto client = Client::connect(server.endpoint(), {.timeout = milliseconds(1000)});
  ASSERT_TRUE(client);
  const auto datasets = client->list_datasets();
  ASSERT_TRUE(datasets);
  const auto step = client->fetch(datasets->front(),
                                  {.dataset = "fake",
                                   .request = {.isovalue = 1},
                                   .steps = StepPolicy::kFinalOnly,
                                   .cached_tile_digests = {}},
                                  [](const FetchedStep&) {}, {.retries = {.most = 0}});
  EXPECT_TRUE(step) << step.error().error.text;
}

}  // namespace
}  // namespace multitetra
