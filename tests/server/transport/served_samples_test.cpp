// Slices and probes through the whole service: requested, sampled, sent, read.
#include <gtest/gtest.h>

#include <cstring>

#include "client/library/client.hpp"
#include "tests/support/fake_steps.hpp"
#include "tests/support/fields.hpp"
#include "tests/support/running_server.hpp"
#include "tests/support/served_datasets.hpp"

namespace multitetra {
namespace {

using testing::RunningServer;

Volume gyroid() { return testing::fields::gyroid(33, 0.2, 5); }

CataloguePtr one_dataset() { return testing::catalogue_with({make_dataset(gyroid(), "gyroid")}); }

Client client_of(const RunningServer& server) {
  auto client = Client::connect(server.endpoint(), {});
  if (!client) throw std::runtime_error(client.error().error.text);
  return *std::move(client);
}

TEST(ServedSamples, ReturnSlicesDuringAStream) {
  const RunningServer server(one_dataset());
  Client client = client_of(server);
  const auto infos = client.list_datasets();
  ASSERT_TRUE(infos);
  const auto reply = client.slice(
      "gyroid",
      {.coordinates = CoordinateSystem::kIndex, .origin = {0, 0, 7}, .width = 33, .height = 33});
  ASSERT_TRUE(reply) << reply.error().error.text;
  EXPECT_EQ(reply->sample_spacing, 1U);
  std::vector<float> values(reply->width * reply->height);
  std::memcpy(values.data(), reply->values->data(), reply->values->size());
  const Volume volume = gyroid();
  const auto& samples = std::get<std::vector<float>>(volume.samples);
  EXPECT_TRUE(std::equal(values.begin(), values.end(),
                         samples.begin() + static_cast<std::ptrdiff_t>(volume.index(0, 0, 7))));
}

TEST(ServedSamples, ReturnTheSampleAtAPickedPoint) {
  const RunningServer server(one_dataset());
  Client client = client_of(server);
  const auto reply = client.probe(
      "gyroid", {.coordinates = CoordinateSystem::kIndex, .places = {{3, 4, 5}, {40, 0, 0}}});
  ASSERT_TRUE(reply) << reply.error().error.text;
  const Volume volume = gyroid();
  const auto& samples = std::get<std::vector<float>>(volume.samples);
  EXPECT_EQ(reply->places[0].value, static_cast<double>(samples[volume.index(3, 4, 5)]));
  EXPECT_TRUE(reply->places[0].gradient);
  EXPECT_FALSE(reply->places[1].value);
}

TEST(ServedSamples, RejectUnknownDatasetsAndSourcesWithoutSamples) {
  const RunningServer server(testing::fake_catalogue());
  Client client = client_of(server);
  const auto nothing = client.slice("nothing", {});
  ASSERT_FALSE(nothing);
  EXPECT_EQ(nothing.error().error.code, ErrorCode::kUnknownDataset);
  const auto fake = client.probe("fake", {.places = {{0, 0, 0}}});
  ASSERT_FALSE(fake);
  EXPECT_EQ(fake.error().error.code, ErrorCode::kInternal);
}

// ---- scalars

// The field x + 10 y + 100 z in world coordinates; its samples differ from those of the surface.
DatasetPtr heat(WorldSpace space = WorldSpace::kUnnamed) {
  Volume volume = testing::fields::sampled<float>({20, 21, 22}, [](int x, int y, int z) {
    return (2.0 * x - 2) + 10 * (2.0 * y - 2) + 100 * (2.0 * z - 2);
  });
  volume.index_to_world = {.columns = {Vec3{2, 0, 0}, Vec3{0, 2, 0}, Vec3{0, 0, 2}},
                           .translation = {-2, -2, -2}};
  volume.spacing = {2, 2, 2};
  volume.meaning.space = space;
  return make_dataset(std::move(volume), "heat");
}

CataloguePtr colored(DatasetPtr field) {
  Volume surface = gyroid();
  surface.meaning.space = WorldSpace::kLps;
  return testing::catalogue_with({make_dataset(std::move(surface), "gyroid"), std::move(field)});
}

OpenStream colored_gyroid(int bits = 16) {
  return {.dataset = "gyroid",
          .request = {.isovalue = 0.1, .error = 0.5, .simplify = true, .normal_bits = 8},
          .scalars = ScalarRequest{.dataset = "heat", .bits = bits}};
}

TEST(ServedSamples, EqualTheFieldAtTheVerticesOfEveryStep) {
  const RunningServer server(colored(heat()));
  Client client = client_of(server);
  const auto infos = client.list_datasets();
  ASSERT_TRUE(infos);
  for (const int bits : {8, 16}) {
    std::size_t steps = 0;
    const auto fetched =
        client.fetch(infos->at(0), colored_gyroid(bits), [&](const FetchedStep& f) {
          ++steps;
          const CommittedStep& step = *f.step;
          ASSERT_TRUE(step.begin.scalars);
          EXPECT_EQ(step.begin.scalars->low, infos->at(1).min);
          ASSERT_EQ(step.mesh.scalars.size(), step.mesh.vertices.size());
          ASSERT_EQ(step.mesh.normals.size(), step.mesh.vertices.size());
          const double allowed = 0.51 * step.begin.scalars->step() + 1e-3;
          for (std::size_t i = 0; i < step.mesh.vertices.size(); ++i) {
            const Vec3 p = grid_coordinates(step.mesh.vertices[i], step.mesh.resolution);
            ASSERT_NEAR(static_cast<double>(step.mesh.scalars[i]), p[0] + 10 * p[1] + 100 * p[2],
                        allowed);
          }
          EXPECT_LT(step.largest_scalar_deviation, 1e-3) << "the field is linear";
        });
    ASSERT_TRUE(fetched) << fetched.error().error.text;
    EXPECT_GT(steps, 0U);
  }
}

TEST(ServedSamples, SendScalarsOfHeldTiles) {
  const RunningServer server(colored(heat()));
  Client client = client_of(server);
  const auto infos = client.list_datasets();
  ASSERT_TRUE(infos);
  DecodedTileCache memory({.tiles = 1000, .triangles = 10'000'000});
  OpenStream plain = colored_gyroid();
  plain.scalars.reset();
  ASSERT_TRUE(client.fetch(infos->at(0), plain, [](const FetchedStep&) {}, {.tiles = &memory}));
  const auto again =
      client.fetch(infos->at(0), colored_gyroid(), [](const FetchedStep&) {}, {.tiles = &memory});
  ASSERT_TRUE(again) << again.error().error.text;
  EXPECT_EQ(again->step->end.tiles_sent, 0U);
  EXPECT_EQ(again->step->mesh.scalars.size(), again->step->mesh.vertices.size());
}

TEST(ServedSamples, RejectScalarsOfUnknownOrOtherWorlds) {
  const RunningServer server(colored(heat(WorldSpace::kRas)));
  Client client = client_of(server);
  const auto infos = client.list_datasets();
  ASSERT_TRUE(infos);
  const auto other = client.fetch(infos->at(0), colored_gyroid(), [](const FetchedStep&) {});
  ASSERT_FALSE(other);
  EXPECT_NE(other.error().error.text.find("world axes"), std::string::npos);
  OpenStream none = colored_gyroid();
  none.scalars->dataset = "cold";
  const auto unknown = client.fetch(infos->at(0), none, [](const FetchedStep&) {});
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().error.code, ErrorCode::kUnknownDataset);
}

// ---- several surfaces

TEST(ServedSamples, SendOnlyPreviewsOnRequest) {
  const RunningServer server(one_dataset());
  Client client = client_of(server);
  const auto infos = client.list_datasets();
  ASSERT_TRUE(infos);
  // The stream begins with this preview, regardless of the machine's speed.
  OpenStream open{.dataset = "gyroid",
                  .request = {.isovalue = 0.1, .error = 0},
                  .steps = StepPolicy::kPreviewsOnly,
                  .resumed_previews = {{.finest_spacing = 8}}};
  const auto preview = client.fetch(
      infos->at(0), open, [](const FetchedStep& f) { EXPECT_FALSE(f.step->begin.is_final); });
  ASSERT_TRUE(preview) << preview.error().error.text;
  open.steps = StepPolicy::kFinalOnly;
  open.resumed_previews.clear();
  const auto last = client.fetch(infos->at(0), open,
                                 [](const FetchedStep& f) { EXPECT_TRUE(f.step->begin.is_final); });
  ASSERT_TRUE(last) << last.error().error.text;
}

}  // namespace
}  // namespace multitetra
