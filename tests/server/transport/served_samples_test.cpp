// Slices and picked places through the whole service: asked, sampled, sent, read.
#include <gtest/gtest.h>

#include <cstring>

#include "client/client.hpp"
#include "server/dataset/prepare.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "tests/support/fake_steps.hpp"
#include "tests/support/fields.hpp"
#include "tests/support/running_server.hpp"

namespace multitetra {
namespace {

using testing::RunningServer;

Volume gyroid() { return testing::fields::gyroid(33, 0.2, 5); }

CataloguePtr one_dataset() {
  return testing::catalogue_of(std::make_shared<ExtractedSteps>(
      std::make_shared<const SurfaceExtractor>(make_dataset(gyroid(), "gyroid"))));
}

Client client_of(const RunningServer& server) {
  auto client = Client::connect(server.endpoint(), {});
  if (!client) throw std::runtime_error(client.error().error.text);
  return *std::move(client);
}

TEST(ServedSamples, ASliceIsTheLayerOfSamplesAndComesBesideAStream) {
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

TEST(ServedSamples, APickedPlaceHasItsSample) {
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

TEST(ServedSamples, OfNoDatasetOrFromASourceWithoutSamplesAreRefused) {
  const RunningServer server(testing::fake_catalogue());
  Client client = client_of(server);
  const auto nothing = client.slice("nothing", {});
  ASSERT_FALSE(nothing);
  EXPECT_EQ(nothing.error().error.code, ErrorCode::kUnknownDataset);
  const auto fake = client.probe("fake", {.places = {{0, 0, 0}}});
  ASSERT_FALSE(fake);
  EXPECT_EQ(fake.error().error.code, ErrorCode::kInternal);
}

}  // namespace
}  // namespace multitetra
