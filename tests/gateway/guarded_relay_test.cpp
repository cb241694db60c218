// What a gateway keeps up on a network: who may come in, what it shows to the servers behind it,
// and how it stops.
#include <atomic>
#include <chrono>
#include <thread>

#include <gtest/gtest.h>

#include "tests/dataset/temporary_folder.hpp"
#include "tests/gateway/relayed_client.hpp"
#include "tests/gateway/running_relay.hpp"
#include "tests/gateway/tls_visit.hpp"
#include "tests/support/eventually.hpp"

namespace multitetra {
namespace {

using namespace std::chrono_literals;
using testing::code_of;
using testing::DoorCertificate;
using testing::end_of_stream;
using testing::eventually;
using testing::FakeSteps;
using testing::greeted;
using testing::HttpClient;
using testing::is_complete;
using testing::is_welcome;
using testing::kAskWhetherAlive;
using testing::octahedron;
using testing::open;
using testing::RunningRelay;
using testing::TlsVisit;
using testing::TokensFile;
using testing::Upstream;
using testing::WebSocketClient;

// ---- tokens

TEST(GuardedRelay, ShowsServersTheTokensOfItsClients) {
  const TemporaryFolder folder;
  const TokensFile tokens(folder.path(), {{"alice", "right", "*"}});
  Upstream upstream(octahedron(), {.keeper = {.tokens = tokens.path()}});
  RunningRelay relay({.relay = {.upstreams = {upstream.endpoint()}}});
  WebSocketClient alice(relay.http());
  EXPECT_TRUE(is_welcome(greeted(alice, "right")));
  open(alice, 1);
  EXPECT_TRUE(is_complete(end_of_stream(alice)));
  WebSocketClient mallory(relay.http());
  EXPECT_EQ(code_of(greeted(mallory, "wrong")), ErrorCode::kUnauthenticated);
  HttpClient http(relay.http());
  EXPECT_EQ(http.get("/v1/datasets").result_int(), 401U);
  EXPECT_EQ(http.get("/v1/datasets", "Authorization: Bearer right\r\n").result_int(), 200U);
}

TEST(GuardedRelay, KnowsItsOwnTokensAndShowsServersItsOwn) {
  const TemporaryFolder folder;
  const TokensFile of_server(folder.path(), {{"gateway", "inner", "*"}});
  Upstream upstream(octahedron(), {.keeper = {.tokens = of_server.path()}});
  const TemporaryFolder outside;
  const TokensFile of_relay(outside.path(), {{"alice", "outer", "*"}, {"bob", "few", "none-*"}});
  RunningRelay relay({.relay = {.upstreams = {upstream.endpoint()}},
                      .upstream_files = {.token = folder.file("token", "inner\n").string()},
                      .reception = {.keeper = {.tokens = of_relay.path()}}});
  WebSocketClient alice(relay.http());
  EXPECT_TRUE(is_welcome(greeted(alice, "outer")));
  open(alice, 1);
  EXPECT_TRUE(is_complete(end_of_stream(alice)));
  WebSocketClient bob(relay.http());
  EXPECT_TRUE(is_welcome(greeted(bob, "few")));
  open(bob, 1);
  EXPECT_EQ(code_of(bob.receive()), ErrorCode::kUnknownDataset) << "He may not see this one.";
  WebSocketClient mallory(relay.http());
  EXPECT_EQ(code_of(greeted(mallory, "inner")), ErrorCode::kUnauthenticated)
      << "The gateway's own token is none of its clients'.";
}

TEST(GuardedRelay, AReloadedListHoldsForThoseWhoAreThere) {
  const TemporaryFolder folder;
  Upstream upstream(octahedron());
  const auto file = folder.file("tokens", access_line("alice", "right", {"*"}));
  RunningRelay relay(
      {.relay = {.upstreams = {upstream.endpoint()}}, .reception = {.keeper = {.tokens = file}}});
  WebSocketClient alice(relay.http());
  EXPECT_TRUE(is_welcome(greeted(alice, "right")));
  (void)folder.file("tokens", access_line("alice", "another", {"*"}));
  relay.reload();
  alice.send(ListDatasets{1});
  EXPECT_EQ(code_of(alice.receive()), ErrorCode::kUnauthenticated);
}

// ---- TLS

TEST(GuardedRelay, SpeaksTlsToServersThatItTrusts) {
  const DoorCertificate certificate;
  Upstream upstream(octahedron(), {.keeper = {.tls = certificate.files()}});
  Endpoint secure = upstream.endpoint();
  secure.transport = Transport::kTls;
  const auto trusting = [&](const DoorCertificate& authority) {
    return RelayServerOptions{
        .relay = {.upstreams = {secure}},
        .upstream_files = {.ca = authority.files().certificate.string(), .needs_tls = true}};
  };
  RunningRelay relay(trusting(certificate));
  WebSocketClient client(relay.http());
  EXPECT_TRUE(is_welcome(greeted(client)));
  open(client, 1);
  EXPECT_TRUE(is_complete(end_of_stream(client)));

  RunningRelay mistrusting(trusting(DoorCertificate()));
  WebSocketClient refused(mistrusting.http());
  EXPECT_EQ(code_of(greeted(refused)), ErrorCode::kUnavailable);
}

TEST(GuardedRelay, HasTlsAtItsOwnDoor) {
  const DoorCertificate certificate;
  Upstream upstream(octahedron());
  RunningRelay relay({.relay = {.upstreams = {upstream.endpoint()}},
                      .reception = {.keeper = {.tls = certificate.files()}}});
  TlsVisit visit(relay.http().port, certificate);
  visit.send(kAskWhetherAlive);
  EXPECT_TRUE(visit.read_to_end().starts_with("HTTP/1.1 200 "));
}

TEST(GuardedRelay, ATokenFileThatCannotBeReadIsToldAtTheStart) {
  EXPECT_THROW(RelayServer({.upstream_files = {.token = "/nowhere/token"}}), ExitError);
}

// ---- limits, metrics, draining

TEST(GuardedRelay, LimitsConnectionsAndRequestsOfAnAddress) {
  Upstream upstream(octahedron());
  RunningRelay relay({.relay = {.upstreams = {upstream.endpoint()}},
                      .reception = {.keeper = {.connections = {.total = 10, .per_name = 1},
                                               .requests = {.per_second = 0.001, .burst = 1}}}});
  WebSocketClient first(relay.http());
  EXPECT_TRUE(is_welcome(greeted(first)));
  HttpClient second(relay.http());
  EXPECT_EQ(second.get("/v1/datasets").result_int(), 503U);
  first.send(ListDatasets{1});
  EXPECT_TRUE(std::holds_alternative<DatasetList>(first.receive()));
  open(first, 1);
  const ServerMessage refused = first.receive();
  EXPECT_EQ(code_of(refused), ErrorCode::kLimitExceeded);
  EXPECT_EQ(std::get<ErrorReply>(refused).request_id, 1U);
}

TEST(GuardedRelay, CountsWhatItPassesOn) {
  Upstream upstream(octahedron());
  RunningRelay relay({.relay = {.upstreams = {upstream.endpoint()}},
                      .reception = {.metrics = std::make_shared<PrometheusMetrics>()}});
  WebSocketClient client(relay.http());
  EXPECT_TRUE(is_welcome(greeted(client)));
  open(client, 1);
  EXPECT_TRUE(is_complete(end_of_stream(client)));
  client.send(Estimate{.request_id = 7, .dataset = "octahedron"});
  EXPECT_TRUE(std::holds_alternative<EstimateReply>(client.receive()));
  HttpClient http(relay.http());
  const std::string text = http.get("/metrics").body();
  for (const std::string& line :
       {std::string("multitetra_requests_total{door=\"websocket\",kind=\"stream\","
                    "outcome=\"complete\"} 1\n"),
        std::string("multitetra_requests_total{door=\"websocket\",kind=\"estimate\","
                    "outcome=\"complete\"} 1\n"),
        "multitetra_upstream_up{upstream=\"" + to_string(upstream.endpoint()) + "\"} 1\n",
        std::string("multitetra_datasets 1\n")}) {
    EXPECT_NE(text.find(line), std::string::npos) << line << text;
  }
}

TEST(GuardedRelay, LetsRunningStreamsEndBeforeItStops) {
  std::atomic<bool> may_end = false;
  std::atomic<bool> has_begun = false;
  Upstream upstream(std::make_shared<FakeSteps>(
      "octahedron", [&](const StepRequest& step, const std::stop_token&) {
        has_begun = true;
        while (!may_end) std::this_thread::sleep_for(1ms);
        return testing::octahedron_step(step);
      }));
  RunningRelay relay({.relay = {.upstreams = {upstream.endpoint()}}});
  WebSocketClient busy(relay.http());
  EXPECT_TRUE(is_welcome(greeted(busy)));
  WebSocketClient other(relay.http());
  EXPECT_TRUE(is_welcome(greeted(other)));
  open(busy, 1);
  ASSERT_TRUE(eventually([&] { return has_begun.load(); }));
  relay.drain();
  HttpClient probe(relay.http());
  EXPECT_TRUE(eventually([&] { return probe.get("/readyz").result_int() == 503U; }));
  open(other, 1);
  EXPECT_EQ(code_of(other.receive()), ErrorCode::kUnavailable);
  may_end = true;
  EXPECT_TRUE(is_complete(end_of_stream(busy)));
  relay.wait();
}

TEST(GuardedRelay, SendsIdleClientsAway) {
  Upstream upstream(octahedron());
  RunningRelay relay({.relay = {.upstreams = {upstream.endpoint()}}, .idle_time = 50ms});
  WebSocketClient idle(relay.http());
  EXPECT_TRUE(is_welcome(greeted(idle)));
  EXPECT_EQ(code_of(idle.receive()), ErrorCode::kUnavailable);
}

}  // namespace
}  // namespace multitetra
