// Slices, probes and colors through a gateway have the answers of a capable server.
#include <gtest/gtest.h>

#include "tests/server/gateway/gateway_client.hpp"
#include "tests/server/gateway/running_gateway.hpp"
#include "tests/support/fields.hpp"
#include "tests/support/served_datasets.hpp"

namespace multitetra {
namespace {

using testing::end_of_stream;
using testing::RunningGateway;
using testing::Upstream;
using testing::WebSocketClient;

DatasetPtr slope(const std::string& name, double steepness) {
  Volume volume = testing::fields::sampled<float>(
      {17, 17, 17}, [steepness](int x, int y, int z) { return steepness * x + y + 100 * z; });
  return make_dataset(std::move(volume), name);
}

std::shared_ptr<DatasetCatalogue> both() {
  return testing::catalogue_with({slope("slope", 1), slope("heat", 2)});
}

void say_hello(WebSocketClient& client) {
  client.send(Hello{});
  EXPECT_EQ(client.receive_a<Welcome>().version, kProtocolVersion);
}

OpenStream colored_slope() {
  return {.request_id = 1,
          .dataset = "slope",
          .request = {.isovalue = 800.5},
          .steps = StepPolicy::kFinalOnly,
          .scalars = ScalarRequest{.dataset = "heat"}};
}

TEST(ForwardedSamples, ForwardsQueriesToAServerWithTheDataset) {
  Upstream upstream(both());
  RunningGateway gateway({.upstream = {.upstreams = {upstream.endpoint()}}});
  WebSocketClient client(gateway.http());
  say_hello(client);
  client.send(Slice{.request_id = 5,
                    .dataset = "heat",
                    .slice = {.origin = {0, 0, 3}, .width = 17, .height = 17}});
  const auto slice = client.receive_a<SliceReply>();
  EXPECT_EQ(slice.request_id, 5U);
  EXPECT_EQ(slice.values->size(), 17U * 17U * sizeof(float));
  client.send(Probe{.request_id = 6, .dataset = "heat", .probe = {.places = {{1, 2, 3}}}});
  EXPECT_EQ(client.receive_a<ProbeReply>().places.at(0).value, 304);
}

TEST(ForwardedSamples, RequestsColoredSurfacesFromAServerWithBothDatasets) {
  Upstream one(testing::catalogue_with({slope("slope", 1)}));
  Upstream other(both());
  RunningGateway gateway({.upstream = {.upstreams = {one.endpoint(), other.endpoint()}}});
  WebSocketClient client(gateway.http());
  say_hello(client);
  client.send(colored_slope());
  std::size_t tiles = 0;
  std::size_t scalars = 0;
  for (;;) {
    const ServerMessage message = client.receive();
    tiles += std::holds_alternative<Tile>(message) ? 1U : 0U;
    scalars += std::holds_alternative<TileScalars>(message) ? 1U : 0U;
    ASSERT_FALSE(std::holds_alternative<ErrorReply>(message));
    if (std::holds_alternative<StreamEnd>(message)) break;
  }
  EXPECT_GT(tiles, 0U);
  EXPECT_EQ(scalars, tiles);
}

TEST(ForwardedSamples, RejectsAStreamWithoutASuitableUpstream) {
  Upstream one(testing::catalogue_with({slope("slope", 1)}));
  Upstream other(testing::catalogue_with({slope("heat", 2)}));
  RunningGateway gateway({.upstream = {.upstreams = {one.endpoint(), other.endpoint()}}});
  WebSocketClient client(gateway.http());
  say_hello(client);
  client.send(colored_slope());
  const ServerMessage refusal = end_of_stream(client);
  ASSERT_TRUE(std::holds_alternative<ErrorReply>(refusal));
  EXPECT_EQ(std::get<ErrorReply>(refusal).error.code, ErrorCode::kUnavailable);
  OpenStream plain = colored_slope();
  plain.request_id = 2;
  plain.scalars.reset();
  client.send(plain);
  EXPECT_TRUE(testing::is_complete(end_of_stream(client)));
}

}  // namespace
}  // namespace multitetra
