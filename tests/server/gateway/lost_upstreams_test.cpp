// Servers behind a gateway that stop, hang and restart.
#include <atomic>
#include <chrono>
#include <optional>
#include <thread>

#include <gtest/gtest.h>

#include "tests/server/gateway/gateway_client.hpp"
#include "tests/server/gateway/running_gateway.hpp"
#include "tests/server/gateway/stub_server.hpp"
#include "tests/support/waiting.hpp"

namespace multitetra {
namespace {

using namespace std::chrono_literals;
using testing::Count;
using testing::end_of_stream;
using testing::endless;
using testing::eventually;
using testing::FakeSteps;
using testing::greeted;
using testing::HangingServer;
using testing::HttpClient;
using testing::is_complete;
using testing::is_welcome;
using testing::octahedron;
using testing::octahedron_step;
using testing::open;
using testing::RunningGateway;
using testing::StubServer;
using testing::Upstream;
using testing::WebSocketClient;

TEST(GatewayFailover, IsReadyOnlyWithAReachableServer) {
  Upstream upstream(octahedron());
  RunningGateway gateway({.upstream = {.upstreams = {upstream.endpoint()}, .max_backoff = 50ms}});
  HttpClient probe(gateway.http());
  const auto is_ready = [&] { return probe.get("/readyz").result_int() == 200U; };
  EXPECT_TRUE(eventually(is_ready));
  upstream.stop();
  EXPECT_TRUE(eventually([&] { return !is_ready(); })) << "without any request";
  upstream.start_again();
  EXPECT_TRUE(eventually(is_ready));
}

TEST(GatewayFailover, TreatsAHangingServerAsLost) {
  HangingServer hanging;
  Upstream good(octahedron());
  RunningGateway gateway({.upstream = {.upstreams = {hanging.endpoint(), good.endpoint()},
                                       .silence_timeout = 100ms,
                                       .min_backoff = 500ms}});
  WebSocketClient client(gateway.http());
  EXPECT_TRUE(is_welcome(greeted(client)));
  for (std::uint64_t id = 1; id <= 4; ++id) {
    open(client, id);
    EXPECT_TRUE(is_complete(end_of_stream(client))) << id;
    client.send(Estimate{.request_id = 100 + id, .dataset = "octahedron"});
    const ServerMessage answer = client.receive();
    ASSERT_TRUE(std::holds_alternative<EstimateReply>(answer)) << id;
    EXPECT_EQ(std::get<EstimateReply>(answer).request_id, 100 + id);
  }
}

// A server that answers Ping is alive, but cannot be used while it refuses connections.
TEST(GatewayFailover, WaitsLongerAfterEachRefusedConnection) {
  std::atomic<int> refused = 0;
  StubServer refusing([&refused](const ClientMessage& message) -> std::optional<ServerMessage> {
    if (const auto* ping = std::get_if<Ping>(&message)) return Pong{.value = ping->value};
    if (!std::holds_alternative<Hello>(message)) return std::nullopt;
    ++refused;
    return ErrorReply{.request_id = 0, .error = {ErrorCode::kUnavailable, "It is starting."}};
  });
  const auto start = std::chrono::steady_clock::now();
  RunningGateway gateway({.upstream = {.upstreams = {refusing.endpoint()}, .min_backoff = 20ms}});
  ASSERT_TRUE(eventually([&] { return refused == 5; }));
  EXPECT_GE(std::chrono::steady_clock::now() - start, 20ms + 40ms + 80ms + 160ms);
}

TEST(GatewayFailover, UsesAServerThatWasUnreachableAtTheStart) {
  Upstream first(octahedron());
  Upstream second(octahedron());
  RunningGateway gateway({.upstream = {.upstreams = {first.endpoint(), second.endpoint()},
                                       .max_backoff = 50ms,
                                       .list_lifetime = 1ms}});
  for (auto& [serving, away] : {std::pair(&first, &second), std::pair(&second, &first)}) {
    away->stop();
    WebSocketClient client(gateway.http());
    EXPECT_TRUE(is_welcome(greeted(client)));
    away->start_again();
    open(client, 1);
    EXPECT_TRUE(is_complete(end_of_stream(client)));
    serving->stop();
    open(client, 2);
    EXPECT_TRUE(is_complete(end_of_stream(client)));
    serving->start_again();
  }
}

// The failover timeout counts only time without a server, not time in which a server works. The
// server that is used first works until it is stopped.
TEST(GatewayFailover, MovesASilentStreamToAnotherServer) {
  Count working_first;
  Count working_second;
  std::atomic<bool> is_first_call = true;
  const auto dataset = [&is_first_call](Count& working) {
    return std::make_shared<FakeSteps>("octahedron", [&](const StepRequest& step,
                                                         const std::stop_token& stop) {
      return is_first_call.exchange(false) ? endless(working)(step, stop) : octahedron_step(step);
    });
  };
  Upstream first(dataset(working_first));
  Upstream second(dataset(working_second));
  constexpr auto kPatience = 1ms;
  RunningGateway gateway({.upstream = {.upstreams = {first.endpoint(), second.endpoint()},
                                       .failover_timeout = kPatience}});
  WebSocketClient client(gateway.http());
  EXPECT_TRUE(is_welcome(greeted(client)));
  open(client, 1);
  ASSERT_TRUE(eventually([&] { return working_first + working_second == 1; }));
  std::this_thread::sleep_for(2 * kPatience);  // Any longer than the timeout.
  (working_first == 1 ? first : second).stop();
  EXPECT_TRUE(is_complete(end_of_stream(client)));
}

// A dataset whose cost estimates are high, so that plans have fewer previews.
class SlowSteps : public FakeSteps {
 public:
  using FakeSteps::FakeSteps;
  [[nodiscard]] CostEstimates costs() const override { return {.plain = 1, .simplified = 1}; }
};

// The previews already sent determine the rest of the stream, not the next server's plan.
TEST(GatewayFailover, KeepsThePreviewsOfAStream) {
  Count working;
  Upstream fast(std::make_shared<FakeSteps>(
      "octahedron", [&](const StepRequest& step, const std::stop_token& stop) {
        return step.finest_spacing == 1 ? endless(working)(step, stop) : octahedron_step(step);
      }));
  Upstream slow(std::make_shared<SlowSteps>("octahedron"));
  const auto previews_of = [](WebSocketClient& client, const auto& when_begun) {
    std::vector<std::int32_t> previews;
    for (;;) {
      const ServerMessage message = client.receive();
      if (const auto* begin = std::get_if<StepBegin>(&message); begin && !begin->is_final) {
        previews.push_back(begin->finest_spacing);
      }
      if (std::holds_alternative<StepEnd>(message)) when_begun(previews);
      if (std::holds_alternative<StreamEnd>(message)) return previews;
      if (std::holds_alternative<ErrorReply>(message)) {
        ADD_FAILURE() << std::get<ErrorReply>(message).error.text;
        return previews;
      }
    }
  };
  fast.stop();
  RunningGateway gateway({.upstream = {.upstreams = {fast.endpoint(), slow.endpoint()},
                                       .max_backoff = 50ms,
                                       .list_lifetime = 1ms}});
  WebSocketClient client(gateway.http());
  EXPECT_TRUE(is_welcome(greeted(client)));
  open(client, 1);
  const auto alone = previews_of(client, [](const auto&) {});
  slow.stop();
  fast.start_again();
  WebSocketClient other(gateway.http());
  EXPECT_TRUE(is_welcome(greeted(other)));
  open(other, 1);
  bool is_lost = false;
  const auto both = previews_of(other, [&](const std::vector<std::int32_t>& previews) {
    if (previews.size() < 2 || std::exchange(is_lost, true)) return;
    ASSERT_TRUE(eventually([&] { return working == 1; }));
    slow.start_again();
    fast.stop();
  });
  EXPECT_TRUE(is_lost);
  EXPECT_GT(both.size(), alone.size()) << "or this test would show nothing";
}

TEST(GatewayFailover, StopsWhileAServerHangs) {
  HangingServer hanging;
  RunningGateway gateway({.upstream = {.upstreams = {hanging.endpoint()}, .silence_timeout = 1h}});
  WebSocketClient client(gateway.http());
  EXPECT_TRUE(is_welcome(greeted(client)));
  client.send(Estimate{.request_id = 1, .dataset = "octahedron"});
  open(client, 2);
  client.send(Ping{1});
  (void)client.receive_a<Pong>();
}  // The destructor of `hanging` waits for that of the gateway.

// Counts the idle connections that a server has closed.
class IdleCount : public ServiceObserver {
 public:
  void refused(const ClientFacts&, const char* reason) override {
    if (std::string_view(reason) == "idle_seconds") ++ended;
  }
  testing::Count ended;
};

// With one server and a backoff beyond the failover timeout, a lost server would fail the stream.
TEST(GatewayFailover, ReconnectsALinkClosedWhileIdle) {
  const auto idle = std::make_shared<IdleCount>();
  Upstream upstream(octahedron(), {.admission = {.observer = idle}, .idle_time = 200ms});
  RunningGateway gateway({.upstream = {.upstreams = {upstream.endpoint()},
                                       .failover_timeout = 5s,
                                       .min_backoff = 20s,
                                       .max_backoff = 20s}});
  WebSocketClient client(gateway.http());
  EXPECT_TRUE(is_welcome(greeted(client)));
  for (int id = 1; id <= 3; ++id) {
    open(client, static_cast<std::uint64_t>(id));
    EXPECT_TRUE(is_complete(end_of_stream(client))) << id;
    // One health-check connection of the gateway, plus those of the streams.
    EXPECT_TRUE(idle->ended.reaches_at_least(1 + id));
  }
}

// Counts the dataset lists that a server has sent.
class ListCount : public ServiceObserver {
 public:
  void request_ended(const ClientFacts&, const RequestFacts& facts) override {
    if (std::string_view(facts.kind) == "list") ++lists;
  }
  std::atomic<int> lists = 0;
};

TEST(GatewayFailover, JoinsEqualRequestsOfSeveralClients) {
  const auto count = std::make_shared<ListCount>();
  Upstream upstream(octahedron(), {.admission = {.observer = count}});
  RunningGateway gateway({.upstream = {.upstreams = {upstream.endpoint()}, .list_lifetime = 1h}});
  std::vector<std::unique_ptr<WebSocketClient>> clients;
  for (int i = 0; i < 20; ++i) clients.push_back(std::make_unique<WebSocketClient>(gateway.http()));
  for (const auto& client : clients) client->send(Hello{});
  for (const auto& client : clients) EXPECT_TRUE(is_welcome(client->receive()));
  EXPECT_EQ(count->lists, 1);
}

}  // namespace
}  // namespace multitetra
