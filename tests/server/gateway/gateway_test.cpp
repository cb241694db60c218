// Clients of a gateway receive what its servers would send, also when a server fails.
#include <algorithm>
#include <atomic>
#include <chrono>

#include <gtest/gtest.h>

#include "server/gateway/detail/forwarded_stream.hpp"
#include "server/gateway/detail/rendezvous.hpp"
#include "server/operations/log.hpp"
#include "tests/server/gateway/gateway_client.hpp"
#include "tests/server/gateway/running_gateway.hpp"
#include "tests/server/gateway/shell_streams.hpp"
#include "tests/support/fake_steps.hpp"

namespace multitetra {
namespace {

using namespace std::chrono_literals;
using testing::all_of_stream;
using testing::ball_step;
using testing::balls;
using testing::catalogue_of;
using testing::eventually;
using testing::FakeSteps;
using testing::HttpClient;
using testing::kBothCodecs;
using testing::octahedron;
using testing::open;
using testing::RunningGateway;
using testing::shown_stream;
using testing::Upstream;
using testing::WebSocketClient;

// ---- pure parts

TEST(Rendezvous, MovesOnlyTheNamesOfALostServer) {
  const std::vector<std::string> three = {"a", "b", "c"};
  std::array<int, 3> first{};
  for (int i = 0; i < 300; ++i) {
    const std::string name = "dataset " + std::to_string(i);
    const auto order = rendezvous_order(name, three);
    ++first.at(order[0]);
    const auto without_c = rendezvous_order(name, {"a", "b"});
    if (order[0] != 2) {
      EXPECT_EQ(without_c[0], order[0]);
    }
  }
  for (const int share : first) EXPECT_GT(share, 60);
}

TEST(ForwardedStream, SkipsSeenStepsAndDetectsDifferences) {
  const auto payload = std::make_shared<const std::string>("bytes");
  const ServerMessage begin = StepBegin{.request_id = 1, .finest_spacing = 8};
  const ServerMessage tile = Tile{.request_id = 1, .index = 3, .payload = payload};
  const ServerMessage other = Tile{.request_id = 1, .index = 4, .payload = payload};
  const ServerMessage end = StepEnd{.request_id = 1, .seconds = 1};
  const ServerMessage later_end = StepEnd{.request_id = 1, .seconds = 2};
  using Verdict = ForwardedStream::Verdict;
  ForwardedStream stream{OpenStream{.request_id = 1}};
  EXPECT_EQ(stream.next(begin), Verdict::kForward);
  EXPECT_EQ(stream.next(tile), Verdict::kForward);
  EXPECT_EQ(stream.next(end), Verdict::kForward);
  stream.restart();
  EXPECT_EQ(stream.next(begin), Verdict::kSkip);
  EXPECT_EQ(stream.next(tile), Verdict::kSkip);
  EXPECT_EQ(stream.next(later_end), Verdict::kSkip);
  EXPECT_EQ(stream.next(begin), Verdict::kForward);
  stream.restart();
  EXPECT_EQ(stream.next(begin), Verdict::kSkip);
  EXPECT_EQ(stream.next(other), Verdict::kDiffers);
}

TEST(ForwardedStream, ContinuesOnTheNextServer) {
  ForwardedStream stream{OpenStream{.request_id = 1}};
  (void)stream.next(StepBegin{.request_id = 1, .finest_spacing = 8, .is_unsimplified = true});
  EXPECT_EQ(stream.open().resumed_previews,
            (std::vector<Preview>{{.finest_spacing = 8, .is_unsimplified = true}}));
  EXPECT_EQ(stream.open().steps, StepPolicy::kProgressive);
  (void)stream.next(StepBegin{.request_id = 1, .step = 1, .is_final = true});
  EXPECT_EQ(stream.open().resumed_previews.size(), 1U);
  EXPECT_EQ(stream.open().steps, StepPolicy::kFinalOnly);
}

TEST(ForwardedStream, NamesFinalShellsAsTheLastPreview) {
  ForwardedStream stream{OpenStream{.request_id = 1, .use = MeshUse::kDisplay}};
  const ShellStep shell = quantized_shells(2);
  (void)stream.next(StepBegin{.request_id = 1, .finest_spacing = 8, .shell = shell});
  (void)stream.next(StepBegin{.request_id = 1, .step = 1, .is_final = true, .shell = shell});
  EXPECT_EQ(stream.open().resumed_previews,
            (std::vector<Preview>{{.finest_spacing = 8, .shell = shell},
                                  {.finest_spacing = 1, .shell = shell}}));
  EXPECT_EQ(stream.open().steps, StepPolicy::kProgressive);
}

// ---- over sockets

void greet(WebSocketClient& client) {
  client.send(Hello{});
  EXPECT_EQ(client.receive_a<Welcome>().version, kProtocolVersion);
}

// Serialized messages without the servers' computing times.
std::vector<std::string> timeless(std::vector<ServerMessage> messages) {
  std::vector<std::string> bytes;
  for (ServerMessage& message : messages) {
    if (auto* end = std::get_if<StepEnd>(&message)) end->seconds = 0;
    bytes.push_back(serialize(message));
  }
  return bytes;
}

TEST(GatewayTest, AnswersLikeAServer) {
  Upstream upstream(octahedron());
  RunningGateway gateway({.upstream = {.upstreams = {upstream.endpoint()}}});
  WebSocketClient client(gateway.http());
  greet(client);
  client.send(ListDatasets{.request_id = 9});
  EXPECT_EQ(client.receive_a<DatasetList>().datasets.at(0), FakeSteps("octahedron").info());
  open(client, 1);
  const auto messages = all_of_stream(client);
  EXPECT_TRUE(std::holds_alternative<StepBegin>(messages.front()));
  EXPECT_EQ(std::get<StreamEnd>(messages.back()).outcome, StreamOutcome::kComplete);
  open(client, 1);
  EXPECT_EQ(client.receive_a<ErrorReply>().error.code, ErrorCode::kInvalidArgument);
  open(client, 2, "none");
  EXPECT_EQ(client.receive_a<ErrorReply>().error.code, ErrorCode::kUnknownDataset);
  client.send(Estimate{.request_id = 7, .dataset = "octahedron"});
  EXPECT_EQ(client.receive_a<EstimateReply>().request_id, 7U);
  client.send(Ping{5});
  EXPECT_EQ(client.receive_a<Pong>().value, 5U);
  open(client, 3);
  EXPECT_EQ(timeless(all_of_stream(client)).size(), messages.size());
}

TEST(GatewayTest, RelaysShellsToClientsThatDecodeThem) {
  Upstream upstream(balls());
  RunningGateway gateway({.upstream = {.upstreams = {upstream.endpoint()}}});
  const auto shells_for = [&](const std::vector<PayloadCodec>& codecs) {
    WebSocketClient client(gateway.http());
    std::vector<bool> shells;
    for (const ServerMessage& message : shown_stream(client, codecs)) {
      if (const auto* begin = std::get_if<StepBegin>(&message)) {
        shells.push_back(begin->shell.has_value());
      }
    }
    return shells;
  };
  const auto with = shells_for(kBothCodecs);
  EXPECT_EQ(std::count(with.begin(), with.end(), false), 0);
  const auto without = shells_for({PayloadCodec::kDracoLattice});
  EXPECT_EQ(std::count(without.begin(), without.end(), true), 0);
}

TEST(GatewayTest, CachesShellsLikeOtherTiles) {
  Upstream upstream(balls());
  RunningGateway gateway({.upstream = {.upstreams = {upstream.endpoint()}}});
  WebSocketClient client(gateway.http());
  HttpClient http(gateway.http());
  StepBegin step;
  for (const ServerMessage& message : shown_stream(client, kBothCodecs)) {
    if (const auto* begin = std::get_if<StepBegin>(&message)) step = *begin;
    const auto* const tile = std::get_if<Tile>(&message);
    if (tile == nullptr) continue;
    const auto kept = testing::kept_tile(http, step.tiles.at(tile->index).digest);
    EXPECT_EQ(kept.result_int(), 200U);
    EXPECT_EQ(kept.body(), *tile->payload);
    EXPECT_EQ(kept[boost::beast::http::field::content_type], "application/octet-stream");
  }
  EXPECT_TRUE(step.is_final);
}

TEST(GatewayTest, ReportsThatNoServerIsReachable) {
  Endpoint unreachable;
  { unreachable = Upstream(octahedron()).endpoint(); }
  RunningGateway gateway({.upstream = {.upstreams = {unreachable}}});
  WebSocketClient client(gateway.http());
  client.send(Hello{});
  EXPECT_EQ(client.receive_a<ErrorReply>().error.code, ErrorCode::kUnavailable);
  client.closed();
  HttpClient http(gateway.http());
  EXPECT_EQ(http.get("/v1/datasets").result_int(), 503U);
  EXPECT_EQ(http.get("/readyz").result_int(), 503U);
  EXPECT_EQ(http.get("/livez").result_int(), 200U);
}

TEST(GatewayTest, StopsCancelledAndSupersededStreams) {
  testing::Count running;
  Upstream upstream(std::make_shared<FakeSteps>("octahedron", testing::endless(running)));
  RunningGateway gateway({.upstream = {.upstreams = {upstream.endpoint()}}});
  WebSocketClient client(gateway.http());
  greet(client);
  open(client, 1);
  ASSERT_TRUE(running.reaches(1));
  open(client, 2);
  EXPECT_EQ(client.receive_a<StreamEnd>().outcome, StreamOutcome::kSuperseded);
  client.send(Cancel{2});
  EXPECT_EQ(client.receive_a<StreamEnd>().outcome, StreamOutcome::kCancelled);
  EXPECT_TRUE(running.reaches(0));
}

TEST(GatewayTest, AnswersHttpLikeAServer) {
  Upstream upstream(octahedron());
  RunningGateway gateway({.upstream = {.upstreams = {upstream.endpoint()}}});
  HttpClient client(gateway.http());
  EXPECT_EQ(client.get("/v1/datasets/octahedron").result_int(), 200U);
  const auto mesh = client.get("/v1/datasets/octahedron/isosurface?isovalue=0.5&format=stl");
  EXPECT_EQ(mesh.result_int(), 200U) << mesh.body();
  EXPECT_EQ(mesh["Multitetra-Triangles"], "10");
  const auto tile = testing::fine_tiles().front();
  EXPECT_EQ(testing::kept_tile(client, tile.summary.digest).body(), *tile.payload);
}

// A step whose first tile does not match its digest.
EncodedStep damaged_step(const StepRequest& step) {
  EncodedStep made = testing::octahedron_step(step);
  std::string payload = *made.tiles.front().payload;
  payload[payload.size() / 2] = static_cast<char>(payload[payload.size() / 2] ^ 0x55);
  made.tiles.front().payload = std::make_shared<const std::string>(std::move(payload));
  return made;
}

TEST(GatewayTest, DropsDamagedTilesAndQuarantinesTheirServer) {
  // The log starts and ends while no thread writes to it.
  ::testing::internal::CaptureStderr();
  start_log({.level = LogLevel::kOff});
  std::string server;
  {
    Upstream damaged(std::make_shared<FakeSteps>(
        "octahedron", [](const StepRequest& step, std::stop_token) { return damaged_step(step); }));
    testing::GatewayOptionsOfTest options{.upstream = {.upstreams = {damaged.endpoint()}}};
    options.upstream.failover_timeout = std::chrono::milliseconds(100);
    options.server.metrics = std::make_shared<PrometheusMetrics>();
    RunningGateway gateway(std::move(options));
    set_log_level(LogLevel::kWarning);
    WebSocketClient client(gateway.http());
    greet(client);
    open(client, 1);
    (void)testing::end_of_stream(client);
    HttpClient http(gateway.http());
    for (int i = 0; i < 500 && http.get("/readyz").result_int() == 200; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    EXPECT_EQ(http.get("/readyz").result_int(), 503U);
    const std::string digest = testing::fine_tiles().front().summary.digest.hex();
    EXPECT_EQ(http.get("/v1/tiles/" + digest).result_int(), 404U);
    const std::string metrics = http.get("/metrics").body();
    EXPECT_NE(metrics.find("multitetra_upstream_damaged_tiles_total{upstream="), std::string::npos);
    open(client, 2);
    EXPECT_EQ(testing::code_of(testing::end_of_stream(client)), ErrorCode::kUnavailable);
    server = to_string(damaged.endpoint());
  }
  start_log({.level = LogLevel::kOff});
  const std::string log = ::testing::internal::GetCapturedStderr();
  EXPECT_NE(log.find("damaged"), std::string::npos) << log;
  EXPECT_NE(log.find(server), std::string::npos) << log;
}

TEST(GatewayTest, QuarantinesAServerThatSendsDamagedShells) {
  Upstream damaged(
      std::make_shared<FakeSteps>("octahedron", [](const StepRequest& step, std::stop_token) {
        EncodedStep made = ball_step(step);
        std::string payload = *made.tiles.front().payload;
        payload.back() = static_cast<char>(payload.back() ^ 0x55);
        made.tiles.front().payload = std::make_shared<const std::string>(std::move(payload));
        return made;
      }));
  RunningGateway gateway({.upstream = {.upstreams = {damaged.endpoint()}}});
  WebSocketClient client(gateway.http());
  (void)shown_stream(client, kBothCodecs);
  HttpClient http(gateway.http());
  for (int i = 0; i < 500 && http.get("/readyz").result_int() == 200; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_EQ(http.get("/readyz").result_int(), 503U);
}

TEST(GatewayTest, ReplacesAServerThatSendsDamagedTiles) {
  Upstream damaged(std::make_shared<FakeSteps>(
      "octahedron", [](const StepRequest& step, std::stop_token) { return damaged_step(step); }));
  Upstream sound(octahedron());
  RunningGateway gateway({.upstream = {.upstreams = {damaged.endpoint(), sound.endpoint()}}});
  HttpClient http(gateway.http());
  // In either order of servers: after one damaged surface the other server is used.
  int refused = 0;
  for (int i = 0; i < 4; ++i) {
    const auto mesh = http.get("/v1/datasets/octahedron/isosurface?isovalue=0.5&format=stl");
    refused += mesh.result_int() == 200 ? 0 : 1;
  }
  EXPECT_LE(refused, 1);
}

// Receives a stream of `messages` messages; its server stops after `seen` of them.
std::vector<ServerMessage> stream_with_loss_after(std::size_t seen, std::size_t messages) {
  auto first = std::make_unique<Upstream>(octahedron());
  auto second = std::make_unique<Upstream>(octahedron());
  RunningGateway gateway({.upstream = {.upstreams = {first->endpoint(), second->endpoint()}}});
  WebSocketClient client(gateway.http());
  greet(client);
  // The hashes of the servers' addresses determine which one serves.
  const auto order =
      rendezvous_order("octahedron", {to_string(first->endpoint()), to_string(second->endpoint())});
  Upstream& serving = order[0] == 0 ? *first : *second;
  open(client, 1);
  std::vector<ServerMessage> received;
  while (received.size() < messages) {
    if (received.size() == seen) serving.stop();
    received.push_back(client.receive());
    if (std::holds_alternative<ErrorReply>(received.back())) break;
  }
  return received;
}

TEST(GatewayTest, DeliversTheSameStreamWhereverItsServerIsLost) {
  Upstream upstream(octahedron());
  RunningGateway gateway({.upstream = {.upstreams = {upstream.endpoint()}}});
  WebSocketClient client(gateway.http());
  greet(client);
  open(client, 1);
  const auto whole = timeless(all_of_stream(client));
  ASSERT_GT(whole.size(), 4U);
  for (std::size_t seen = 0; seen < whole.size(); ++seen) {
    EXPECT_EQ(timeless(stream_with_loss_after(seen, whole.size())), whole) << seen;
  }
}

// Large, slow steps, so that the server is lost while it sends one.
TEST(GatewayTest, ContinuesInTheMiddleOfAStep) {
  const auto heavy = [] {
    return std::make_shared<FakeSteps>("octahedron", testing::heavy(40, 1'000'000));
  };
  Upstream first(heavy());
  Upstream second(heavy());
  RunningGateway gateway({.upstream = {.upstreams = {first.endpoint(), second.endpoint()}}});
  WebSocketClient client(gateway.http());
  greet(client);
  const auto order =
      rendezvous_order("octahedron", {to_string(first.endpoint()), to_string(second.endpoint())});
  client.send(OpenStream{.request_id = 1,
                         .dataset = "octahedron",
                         .steps = StepPolicy::kFinalOnly,
                         .cached_tile_digests = {}});
  client.receive_a<StepBegin>();
  for (std::uint32_t tile = 0; tile < 40; ++tile) {
    if (tile == 5) (order[0] == 0 ? first : second).stop();
    EXPECT_EQ(client.receive_a<Tile>().index, tile);
  }
  client.receive_a<StepEnd>();
  EXPECT_EQ(client.receive_a<StreamEnd>().outcome, StreamOutcome::kComplete);
}

TEST(GatewayTest, RequestsPreviewsOfSeveralDatasetsFromOneServer) {
  const auto with = [](const std::vector<std::string>& others) {
    auto catalogue = catalogue_of(octahedron());
    for (const std::string& name : others) catalogue->add(std::make_shared<FakeSteps>(name));
    return catalogue;
  };
  Upstream first(with({"a", "b"}));
  Upstream second(with({"b", "c"}));
  RunningGateway gateway({.upstream = {.upstreams = {first.endpoint(), second.endpoint()}}});
  WebSocketClient client(gateway.http());
  greet(client);
  const auto request = [&](std::uint64_t id, std::vector<std::string> further) {
    client.send(OpenStream{.request_id = id,
                           .dataset = "octahedron",
                           .steps = StepPolicy::kPreviewsOnly,
                           .resumed_previews = {{.finest_spacing = 4}},
                           .further_datasets = std::move(further)});
    return all_of_stream(client);
  };
  const auto previews = request(1, {"b", "c"});
  EXPECT_EQ(std::get<StreamEnd>(previews.back()).steps, 3U);
  EXPECT_EQ(testing::code_of(request(2, {"a", "c"}).back()), ErrorCode::kUnavailable);
  EXPECT_EQ(std::get<StreamEnd>(request(3, {"a"}).back()).steps, 2U);
}

TEST(GatewayTest, WaitsForItsOnlyServerToComeBack) {
  Upstream upstream(octahedron());
  RunningGateway gateway(
      {.upstream = {.upstreams = {upstream.endpoint()}, .min_backoff = 10ms, .max_backoff = 50ms}});
  WebSocketClient client(gateway.http());
  greet(client);
  upstream.stop();
  open(client, 1);
  HttpClient probe(gateway.http());
  EXPECT_TRUE(eventually([&] { return probe.get("/readyz").result_int() == 503U; }));
  upstream.start_again();
  EXPECT_EQ(std::get<StreamEnd>(all_of_stream(client).back()).outcome, StreamOutcome::kComplete);
}

TEST(GatewayTest, FailsAStreamWithoutReachableServers) {
  Upstream upstream(octahedron());
  RunningGateway gateway(
      {.upstream = {.upstreams = {upstream.endpoint()}, .failover_timeout = 100ms}});
  WebSocketClient client(gateway.http());
  greet(client);
  upstream.stop();
  open(client, 1);
  EXPECT_EQ(client.receive_a<ErrorReply>().error.code, ErrorCode::kUnavailable);
  client.send(Ping{1});
  client.receive_a<Pong>();
}

// The other server's dataset has the same metadata but another surface. The large tiles ensure that
// most of the answer is still unsent when the first server stops.
TEST(GatewayTest, NeverMixesDifferingServers) {
  const auto heavy = [](std::size_t tiles) {
    return std::make_shared<FakeSteps>("octahedron", testing::heavy(tiles, 1'000'000));
  };
  Upstream first(heavy(60));
  Upstream second(heavy(61));
  RunningGateway gateway({.upstream = {.upstreams = {first.endpoint(), second.endpoint()}}});
  WebSocketClient client(gateway.http());
  greet(client);
  const auto order =
      rendezvous_order("octahedron", {to_string(first.endpoint()), to_string(second.endpoint())});
  client.send(OpenStream{.request_id = 1,
                         .dataset = "octahedron",
                         .steps = StepPolicy::kFinalOnly,
                         .cached_tile_digests = {}});
  client.receive_a<StepBegin>();
  (order[0] == 0 ? first : second).stop();
  const auto rest = all_of_stream(client);
  ASSERT_TRUE(std::holds_alternative<ErrorReply>(rest.back()));
  EXPECT_EQ(std::get<ErrorReply>(rest.back()).error.code, ErrorCode::kUnavailable);
}

}  // namespace
}  // namespace multitetra
