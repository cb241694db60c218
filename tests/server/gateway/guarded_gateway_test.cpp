// Security of a gateway: access, the credentials it sends to its upstreams, and how it stops.
#include <atomic>
#include <chrono>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "common/base/exit_codes.hpp"
#include "tests/server/gateway/gateway_client.hpp"
#include "tests/server/gateway/running_gateway.hpp"
#include "tests/server/gateway/shell_streams.hpp"
#include "tests/server/http/tls_request.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/waiting.hpp"

namespace multitetra {
namespace {

using namespace std::chrono_literals;
using testing::code_of;
using testing::end_of_stream;
using testing::eventually;
using testing::FakeSteps;
using testing::greeted;
using testing::HttpClient;
using testing::is_complete;
using testing::is_welcome;
using testing::kAskWhetherAlive;
using testing::ListenerCertificate;
using testing::octahedron;
using testing::open;
using testing::RunningGateway;
using testing::TlsRequest;
using testing::TokensFile;
using testing::Upstream;
using testing::WebSocketClient;

// ---- tokens

TEST(GuardedGateway, ForwardsClientTokensToServers) {
  const TemporaryFolder folder;
  const TokensFile tokens(folder.path(), {{"alice", "right", "*"}});
  Upstream upstream(octahedron(), {.admission = {.tokens = tokens.path()}});
  RunningGateway gateway({.upstream = {.upstreams = {upstream.endpoint()}}});
  WebSocketClient alice(gateway.http());
  EXPECT_TRUE(is_welcome(greeted(alice, "right")));
  open(alice, 1);
  EXPECT_TRUE(is_complete(end_of_stream(alice)));
  WebSocketClient mallory(gateway.http());
  EXPECT_EQ(code_of(greeted(mallory, "wrong")), ErrorCode::kUnauthenticated);
  HttpClient http(gateway.http());
  EXPECT_EQ(http.get("/v1/datasets").result_int(), 401U);
  EXPECT_EQ(http.get("/v1/datasets", "Authorization: Bearer right\r\n").result_int(), 200U);
}

// The gateway has no tokens file, so the servers' rights apply.
TEST(GuardedGateway, SendsTilesOnlyOfVisibleDatasets) {
  const TemporaryFolder folder;
  const TokensFile tokens(folder.path(), {{"alice", "right", "*"}, {"bob", "few", "none-*"}});
  Upstream upstream(octahedron(), {.admission = {.tokens = tokens.path()}});
  RunningGateway gateway({.upstream = {.upstreams = {upstream.endpoint()}}});
  WebSocketClient alice(gateway.http());
  EXPECT_TRUE(is_welcome(greeted(alice, "right")));
  open(alice, 1);
  EXPECT_TRUE(is_complete(end_of_stream(alice)));
  const ContentDigest digest = testing::fine_tiles().front().summary.digest;
  const std::string path = "/v1/tiles/" + digest.hex();
  HttpClient http(gateway.http());
  const auto hers = testing::kept_tile(http, digest, "Authorization: Bearer right\r\n");
  EXPECT_EQ(hers.result_int(), 200U);
  EXPECT_TRUE(hers["Cache-Control"].starts_with("private"));
  EXPECT_EQ(http.get(path).result_int(), 401U);
  EXPECT_EQ(http.get(path, "Authorization: Bearer wrong\r\n").result_int(), 401U);
  EXPECT_EQ(http.get(path, "Authorization: Bearer few\r\n").result_int(), 404U);
}

// Shells cached from Alice's streams are not sent to Bob, who may not read samples, whether the
// server or the gateway holds the tokens.
class ShellsOfAGateway : public ::testing::Test {
 protected:
  void expect_for_alice_alone(RunningGateway& gateway) {
    WebSocketClient alice(gateway.http());
    HttpClient http(gateway.http());
    bool has_shells = false;
    StepBegin step;
    for (const ServerMessage& message :
         testing::shown_stream(alice, testing::kBothCodecs, "samples")) {
      if (const auto* begin = std::get_if<StepBegin>(&message)) step = *begin;
      const auto* const tile = std::get_if<Tile>(&message);
      if (tile == nullptr) continue;
      ASSERT_TRUE(step.shell);
      has_shells = true;
      const ContentDigest digest = step.tiles.at(tile->index).digest;
      const auto hers = testing::kept_tile(http, digest, "Authorization: Bearer samples\r\n");
      EXPECT_EQ(hers.result_int(), 200U);
      EXPECT_EQ(hers.body(), *tile->payload);
      const std::string path = "/v1/tiles/" + digest.hex();
      EXPECT_EQ(http.get(path, "Authorization: Bearer surfaces\r\n").result_int(), 404U);
    }
    EXPECT_TRUE(has_shells);
    WebSocketClient bob(gateway.http());
    EXPECT_TRUE(is_welcome(greeted(bob, "surfaces")));
    open(bob, 1);
    EXPECT_TRUE(is_complete(end_of_stream(bob)));
    const auto his = testing::kept_tile(http, testing::fine_tiles().front().summary.digest,
                                        "Authorization: Bearer surfaces\r\n");
    EXPECT_EQ(his.result_int(), 200U) << "Draco tiles are for him.";
  }

  TemporaryFolder folder_;
  TokensFile tokens_{folder_.path(),
                     {{"alice", "samples", "*"}, {"bob", "surfaces", "* only=surfaces"}}};
};

TEST_F(ShellsOfAGateway, AreHiddenFromSurfacesOnlyTokensOfTheServer) {
  Upstream upstream(testing::balls(), {.admission = {.tokens = tokens_.path()}});
  RunningGateway gateway({.upstream = {.upstreams = {upstream.endpoint()}}});
  expect_for_alice_alone(gateway);
}

TEST_F(ShellsOfAGateway, AreHiddenFromSurfacesOnlyTokensOfTheGateway) {
  Upstream upstream(testing::balls());
  RunningGateway gateway({.upstream = {.upstreams = {upstream.endpoint()}},
                          .server = {.admission = {.tokens = tokens_.path()}}});
  expect_for_alice_alone(gateway);
}

TEST(GuardedGateway, ChecksClientTokensAndSendsItsOwnToServers) {
  const TemporaryFolder folder;
  const TokensFile of_server(folder.path(), {{"gateway", "inner", "*"}});
  Upstream upstream(octahedron(), {.admission = {.tokens = of_server.path()}});
  const TemporaryFolder outside;
  const TokensFile of_gateway(outside.path(), {{"alice", "outer", "*"}, {"bob", "few", "none-*"}});
  RunningGateway gateway({.upstream = {.upstreams = {upstream.endpoint()}},
                          .upstream_files = {.token = folder.file("token", "inner\n").string()},
                          .server = {.admission = {.tokens = of_gateway.path()}}});
  WebSocketClient alice(gateway.http());
  EXPECT_TRUE(is_welcome(greeted(alice, "outer")));
  open(alice, 1);
  EXPECT_TRUE(is_complete(end_of_stream(alice)));
  WebSocketClient bob(gateway.http());
  EXPECT_TRUE(is_welcome(greeted(bob, "few")));
  open(bob, 1);
  EXPECT_EQ(code_of(bob.receive()), ErrorCode::kUnknownDataset) << "He may not see this one.";
  WebSocketClient mallory(gateway.http());
  EXPECT_EQ(code_of(greeted(mallory, "inner")), ErrorCode::kUnauthenticated)
      << "The gateway's own token is none of its clients'.";
}

TEST(GuardedGateway, AppliesAReloadedAccessListToOpenConnections) {
  const TemporaryFolder folder;
  Upstream upstream(octahedron());
  const auto file = folder.file("tokens", access_line("alice", "right", {"*"}));
  RunningGateway gateway({.upstream = {.upstreams = {upstream.endpoint()}},
                          .server = {.admission = {.tokens = file}}});
  WebSocketClient alice(gateway.http());
  EXPECT_TRUE(is_welcome(greeted(alice, "right")));
  (void)folder.file("tokens", access_line("alice", "another", {"*"}));
  gateway.reload();
  alice.send(ListDatasets{1});
  EXPECT_EQ(code_of(alice.receive()), ErrorCode::kUnauthenticated);
}

// Counts the rejected tokens and the connections of a server.
struct CountedRefusals : ServiceObserver {
  std::atomic<int> connections = 0;
  std::atomic<int> welcomed_clients = 0;
  void welcomed(const ClientFacts&) override { ++welcomed_clients; }
  std::atomic<int> unauthenticated = 0;
  void connected(const ClientFacts&) override { ++connections; }
  void error_answered(const ClientFacts&, const Error& error, std::uint64_t) override {
    unauthenticated += error.code == ErrorCode::kUnauthenticated;
  }
};

// Without a token of its own, a gateway keeps checking the health of such a server.
TEST(GuardedGateway, IsNotRefusedByAServerWithTokens) {
  const TemporaryFolder folder;
  const TokensFile tokens(folder.path(), {{"alice", "right", "*"}});
  const auto counted = std::make_shared<CountedRefusals>();
  Upstream upstream(octahedron(), {.admission = {.tokens = tokens.path(), .observer = counted}});
  RunningGateway gateway(
      {.upstream = {.upstreams = {upstream.endpoint()}, .silence_timeout = 100ms}});
  ASSERT_TRUE(eventually([&] { return counted->connections >= 4; }));
  HttpClient http(gateway.http());
  EXPECT_TRUE(eventually([&] { return http.get("/readyz").result_int() == 200U; }));
  upstream.stop();
  EXPECT_TRUE(eventually([&] { return http.get("/readyz").result_int() == 503U; }));
  upstream.start_again();
  EXPECT_TRUE(eventually([&] { return http.get("/readyz").result_int() == 200U; }));
  EXPECT_EQ(counted->unauthenticated, 0);
  EXPECT_EQ(counted->welcomed_clients, 0) << "probes fill the log of a server";
}

// Records the peer of the last stream, as the log names it.
struct StreamPeers : ServiceObserver {
  std::mutex mutex;
  std::string last;
  void request_ended(const ClientFacts& client, const RequestFacts& facts) override {
    const std::lock_guard lock(mutex);
    if (std::string_view(facts.kind) == "stream") last = client.peer;
  }
  [[nodiscard]] std::string peer() {
    const std::lock_guard lock(mutex);
    return last;
  }
};

TEST(GuardedGateway, ForwardsClientAddressesToTrustingServers) {
  for (const bool is_trusted : {true, false}) {
    const auto at_server = std::make_shared<StreamPeers>();
    const auto at_gateway = std::make_shared<StreamPeers>();
    ServerOptions trusting{.admission = {.observer = at_server}};
    if (is_trusted) trusting.admission.trusted_proxies = *AddressRanges::parse({"127.0.0.1"});
    Upstream upstream(octahedron(), trusting);
    RunningGateway gateway({.upstream = {.upstreams = {upstream.endpoint()}},
                            .server = {.admission = {.observer = at_gateway}}});
    WebSocketClient client(gateway.http());
    EXPECT_TRUE(is_welcome(greeted(client)));
    open(client, 1);
    EXPECT_TRUE(is_complete(end_of_stream(client)));
    ASSERT_TRUE(
        eventually([&] { return !at_server->peer().empty() && !at_gateway->peer().empty(); }));
    EXPECT_EQ(at_server->peer() == at_gateway->peer(), is_trusted) << at_server->peer();
  }
}

// The numbers of requests, as the log names them.
struct RequestNumbers : ServiceObserver {
  std::mutex mutex;
  std::vector<std::string> all;
  void request_ended(const ClientFacts&, const RequestFacts& facts) override {
    const std::lock_guard lock(mutex);
    if (!facts.dataset.empty()) all.push_back(facts.kind + (" " + std::to_string(facts.request)));
  }
  [[nodiscard]] std::vector<std::string> seen() {
    const std::lock_guard lock(mutex);
    return all;
  }
};

TEST(GuardedGateway, ForwardsHttpRequestIdsToServerLogs) {
  const auto numbers = std::make_shared<RequestNumbers>();
  Upstream upstream(octahedron(), {.admission = {.observer = numbers}});
  RunningGateway gateway({.upstream = {.upstreams = {upstream.endpoint()}}});
  HttpClient http(gateway.http());
  const auto id_of = [&](const std::string& target) {
    return std::string(http.get("/v1/datasets/octahedron/" + target)["X-Request-Id"]);
  };
  const std::string surface = id_of("isosurface?isovalue=0&format=ply");
  const std::string value = id_of("probe?at=0,0,0");
  ASSERT_TRUE(eventually([&] { return numbers->seen().size() >= 2; }));
  EXPECT_EQ(numbers->seen(), (std::vector{"stream " + surface, "probe " + value}));
}

// ---- TLS

TEST(GuardedGateway, ConnectsToTrustedServersOverTls) {
  const ListenerCertificate certificate;
  Upstream upstream(octahedron(), {.admission = {.tls = certificate.files()}});
  Endpoint secure = upstream.endpoint();
  secure.transport = Transport::kTls;
  const auto trusting = [&](const ListenerCertificate& authority) {
    return testing::GatewayOptionsOfTest{
        .upstream = {.upstreams = {secure}},
        .upstream_files = {.ca = authority.files().certificate.string(), .needs_tls = true}};
  };
  RunningGateway gateway(trusting(certificate));
  WebSocketClient client(gateway.http());
  EXPECT_TRUE(is_welcome(greeted(client)));
  open(client, 1);
  EXPECT_TRUE(is_complete(end_of_stream(client)));

  RunningGateway mistrusting(trusting(ListenerCertificate()));
  WebSocketClient refused(mistrusting.http());
  EXPECT_EQ(code_of(greeted(refused)), ErrorCode::kUnavailable);
}

TEST(GuardedGateway, ServesTlsItself) {
  const ListenerCertificate certificate;
  Upstream upstream(octahedron());
  RunningGateway gateway({.upstream = {.upstreams = {upstream.endpoint()}},
                          .server = {.admission = {.tls = certificate.files()}}});
  TlsRequest visit(gateway.http().port, certificate);
  visit.send(kAskWhetherAlive);
  EXPECT_TRUE(visit.read_to_end().starts_with("HTTP/1.1 200 "));
}

TEST(GuardedGateway, ReportsAnUnreadableTokenFileAtTheStart) {
  EXPECT_THROW(RunningGateway({.upstream_files = {.token = "/nowhere/token"}}), ExitError);
}

// ---- limits, metrics, draining

TEST(GuardedGateway, LimitsConnectionsAndRequestsOfAnAddress) {
  Upstream upstream(octahedron());
  RunningGateway gateway(
      {.upstream = {.upstreams = {upstream.endpoint()}},
       .server = {.admission = {.connections = {.total = 10, .per_name = 1},
                                .requests = {.per_second = 0.001, .burst = 1}}}});
  WebSocketClient first(gateway.http());
  EXPECT_TRUE(is_welcome(greeted(first)));
  HttpClient second(gateway.http());
  EXPECT_EQ(second.get("/v1/datasets").result_int(), 503U);
  first.send(ListDatasets{1});
  EXPECT_TRUE(std::holds_alternative<DatasetList>(first.receive()));
  open(first, 1);
  const ServerMessage refused = first.receive();
  EXPECT_EQ(code_of(refused), ErrorCode::kLimitExceeded);
  EXPECT_EQ(std::get<ErrorReply>(refused).request_id, 1U);
}

TEST(GuardedGateway, CountsForwardedRequests) {
  Upstream upstream(octahedron());
  RunningGateway gateway({.upstream = {.upstreams = {upstream.endpoint()}},
                          .server = {.metrics = std::make_shared<PrometheusMetrics>()}});
  WebSocketClient client(gateway.http());
  EXPECT_TRUE(is_welcome(greeted(client)));
  open(client, 1);
  EXPECT_TRUE(is_complete(end_of_stream(client)));
  client.send(Estimate{.request_id = 7, .dataset = "octahedron"});
  EXPECT_TRUE(std::holds_alternative<EstimateReply>(client.receive()));
  HttpClient http(gateway.http());
  const std::string text = http.get("/metrics").body();
  for (const std::string& line :
       {std::string("multitetra_requests_total{kind=\"stream\",outcome=\"complete\","
                    "transport=\"websocket\"} 1\n"),
        std::string("multitetra_requests_total{kind=\"estimate\",outcome=\"complete\","
                    "transport=\"websocket\"} 1\n"),
        "multitetra_upstream_up{upstream=\"" + to_string(upstream.endpoint()) + "\"} 1\n",
        std::string("multitetra_datasets 1\n")}) {
    EXPECT_NE(text.find(line), std::string::npos) << line << text;
  }
}

TEST(GuardedGateway, CompletesRunningStreamsBeforeStopping) {
  testing::Gate may_end;
  testing::Gate has_begun;
  Upstream upstream(std::make_shared<FakeSteps>(
      "octahedron", [&](const StepRequest& step, const std::stop_token&) {
        has_begun.open();
        may_end.pass();
        return testing::octahedron_step(step);
      }));
  RunningGateway gateway({.upstream = {.upstreams = {upstream.endpoint()}}});
  WebSocketClient busy(gateway.http());
  EXPECT_TRUE(is_welcome(greeted(busy)));
  WebSocketClient other(gateway.http());
  EXPECT_TRUE(is_welcome(greeted(other)));
  open(busy, 1);
  ASSERT_TRUE(has_begun.pass());
  gateway.drain();
  HttpClient probe(gateway.http());
  EXPECT_TRUE(eventually([&] { return probe.get("/readyz").result_int() == 503U; }));
  open(other, 1);
  EXPECT_EQ(code_of(other.receive()), ErrorCode::kUnavailable);
  may_end.open();
  EXPECT_TRUE(is_complete(end_of_stream(busy)));
  gateway.wait();
}

TEST(GuardedGateway, ClosesIdleClients) {
  Upstream upstream(octahedron());
  RunningGateway gateway(
      {.upstream = {.upstreams = {upstream.endpoint()}}, .server = {.idle_time = 50ms}});
  WebSocketClient idle(gateway.http());
  EXPECT_TRUE(is_welcome(greeted(idle)));
  EXPECT_EQ(code_of(idle.receive()), ErrorCode::kUnavailable);
}

}  // namespace
}  // namespace multitetra
