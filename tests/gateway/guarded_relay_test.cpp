// What a gateway keeps up on a network: who may come in, what it shows to the servers behind it,
// how it learns that one of them is gone, and how it stops.
#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>

#include <gtest/gtest.h>

#include "common/frame.hpp"
#include "tests/dataset/temporary_folder.hpp"
#include "tests/gateway/running_relay.hpp"
#include "tests/support/certificates.hpp"

namespace multitetra {
namespace {

using namespace std::chrono_literals;
using testing::FakeSteps;
using testing::HttpClient;
using testing::RunningRelay;
using testing::TokensFile;
using testing::Upstream;
using testing::WebSocketClient;

std::shared_ptr<FakeSteps> octahedron() { return std::make_shared<FakeSteps>("octahedron"); }

ServerMessage greeted(WebSocketClient& client, const std::string& token = {}) {
  client.send(Hello{.token = token});
  return client.receive();
}

bool is_welcome(const ServerMessage& message) { return std::holds_alternative<Welcome>(message); }

ErrorCode code_of(const ServerMessage& message) {
  const auto* reply = std::get_if<ErrorReply>(&message);
  return reply ? reply->error.code : ErrorCode::kUnknown;
}

void open(WebSocketClient& client, std::uint64_t id) {
  client.send(OpenStream{.request_id = id, .dataset = "octahedron", .held = {}});
}

// The last message of the stream that runs.
ServerMessage end_of_stream(WebSocketClient& client) {
  for (;;) {
    ServerMessage message = client.receive();
    if (std::holds_alternative<StreamEnd>(message) || std::holds_alternative<ErrorReply>(message))
      return message;
  }
}

bool is_complete(const ServerMessage& last) {
  const auto* end = std::get_if<StreamEnd>(&last);
  return end && end->outcome == StreamOutcome::kComplete;
}

bool eventually(const std::function<bool()>& happened) {
  for (int i = 0; i < 5000; ++i) {
    if (happened()) return true;
    std::this_thread::sleep_for(1ms);
  }
  return false;
}

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
  const TemporaryFolder folder;
  const testing::CertificateAndKey made = testing::self_signed();
  const TlsFiles files = {folder.file("server.pem", made.certificate),
                          folder.file("server.key", made.key)};
  Upstream upstream(octahedron(), {.keeper = {.tls = files}});
  Endpoint secure = upstream.endpoint();
  secure.transport = Transport::kTls;
  RunningRelay trusting({.relay = {.upstreams = {secure}},
                         .upstream_files = {.ca = files.certificate.string(), .needs_tls = true}});
  WebSocketClient client(trusting.http());
  EXPECT_TRUE(is_welcome(greeted(client)));
  open(client, 1);
  EXPECT_TRUE(is_complete(end_of_stream(client)));

  const testing::CertificateAndKey other = testing::self_signed();
  RunningRelay mistrusting(
      {.relay = {.upstreams = {secure}},
       .upstream_files = {.ca = folder.file("other.pem", other.certificate).string(),
                          .needs_tls = true}});
  WebSocketClient refused(mistrusting.http());
  EXPECT_EQ(code_of(greeted(refused)), ErrorCode::kUnavailable);
}

TEST(GuardedRelay, HasTlsAtItsOwnDoor) {
  const TemporaryFolder folder;
  const testing::CertificateAndKey made = testing::self_signed();
  const TlsFiles files = {folder.file("door.pem", made.certificate),
                          folder.file("door.key", made.key)};
  Upstream upstream(octahedron());
  RunningRelay relay(
      {.relay = {.upstreams = {upstream.endpoint()}}, .reception = {.keeper = {.tls = files}}});
  asio::io_context io;
  asio::ssl::context context(asio::ssl::context::tls_client);
  context.add_certificate_authority(asio::buffer(made.certificate));
  context.set_verify_mode(asio::ssl::verify_peer);
  asio::ssl::stream<tcp::socket> client(io, context);
  client.next_layer().connect({asio::ip::make_address("127.0.0.1"), relay.http().port});
  client.handshake(asio::ssl::stream_base::client);
  asio::write(client, asio::buffer(std::string_view("GET /livez HTTP/1.1\r\nHost: x\r\n\r\n")));
  beast::flat_buffer buffer;
  http::response<http::string_body> answer;
  http::read(client, buffer, answer);
  EXPECT_EQ(answer.result_int(), 200U);
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

// ---- servers that go, hang and come

TEST(GuardedRelay, IsReadyOnlyWhileAServerIsThere) {
  Upstream upstream(octahedron());
  RunningRelay relay({.relay = {.upstreams = {upstream.endpoint()}, .most_backoff = 50ms}});
  HttpClient probe(relay.http());
  const auto is_ready = [&] { return probe.get("/readyz").result_int() == 200U; };
  EXPECT_TRUE(eventually(is_ready));
  upstream.stop();
  EXPECT_TRUE(eventually([&] { return !is_ready(); })) << "though nobody has asked for anything";
  upstream.start_again();
  EXPECT_TRUE(eventually(is_ready));
}

// Says Welcome and what it has, and nothing else: as a process that hangs in the middle of work.
class HangingServer {
 public:
  HangingServer() : acceptor_(io_, {asio::ip::make_address("127.0.0.1"), 0}) {
    asio::co_spawn(
        io_, [this] { return accept(); }, asio::detached);
    thread_ = std::thread([this] { io_.run(); });
  }
  ~HangingServer() {
    io_.stop();
    thread_.join();
  }
  [[nodiscard]] Endpoint endpoint() const {
    return {.host = "127.0.0.1", .port = acceptor_.local_endpoint().port()};
  }

 private:
  asio::awaitable<void> accept() {
    for (;;) {
      auto socket =
          std::make_shared<tcp::socket>(co_await acceptor_.async_accept(asio::use_awaitable));
      asio::co_spawn(
          io_, [this, socket] { return talk(socket); }, asio::detached);
    }
  }
  asio::awaitable<void> talk(std::shared_ptr<tcp::socket> socket) {
    FrameReader frames(kMaxClientFrameBytes);
    std::array<char, 4096> buffer{};
    for (;;) {
      const auto content = frames.next();
      if (!content) co_return;
      if (*content) {
        const auto message = parse_client_message(**content);
        std::string answer;
        if (message && std::holds_alternative<Hello>(*message)) answer = serialize(Welcome{});
        if (const auto* list = message ? std::get_if<ListDatasets>(&*message) : nullptr) {
          answer = serialize(
              DatasetList{.request_id = list->request_id, .datasets = {octahedron()->info()}});
        }
        if (answer.empty()) continue;
        answer = frame_header(static_cast<std::uint32_t>(answer.size())) + answer;
        co_await asio::async_write(*socket, asio::buffer(answer), asio::use_awaitable);
      } else {
        const std::size_t size =
            co_await socket->async_read_some(asio::buffer(buffer), asio::use_awaitable);
        frames.feed({buffer.data(), size});
      }
    }
  }

  asio::io_context io_;
  tcp::acceptor acceptor_;
  std::thread thread_;
};

TEST(GuardedRelay, TakesAServerThatHangsForALostOne) {
  HangingServer hanging;
  Upstream good(octahedron());
  RunningRelay relay({.relay = {.upstreams = {hanging.endpoint(), good.endpoint()},
                                .silence = 100ms,
                                .least_backoff = 500ms}});
  WebSocketClient client(relay.http());
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

TEST(GuardedRelay, GoesOnWithAServerThatWasAwayWhenItsClientCame) {
  Upstream first(octahedron());
  Upstream second(octahedron());
  RunningRelay relay({.relay = {.upstreams = {first.endpoint(), second.endpoint()},
                                .most_backoff = 50ms,
                                .list_lifetime = 1ms}});
  for (auto& [serving, away] : {std::pair(&first, &second), std::pair(&second, &first)}) {
    away->stop();
    WebSocketClient client(relay.http());
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

TEST(GuardedRelay, StopsWhileAServerHangs) {
  HangingServer hanging;
  RunningRelay relay({.relay = {.upstreams = {hanging.endpoint()}, .silence = 1h}});
  WebSocketClient client(relay.http());
  EXPECT_TRUE(is_welcome(greeted(client)));
  client.send(Estimate{.request_id = 1, .dataset = "octahedron"});
  open(client, 2);
  client.send(Ping{1});
  (void)client.receive_a<Pong>();
}  // Whose end waits for the gateway's.

// With one server and a backoff beyond all patience a loss would fail the stream.
TEST(GuardedRelay, ALinkThatTheServerClosedMeanwhileIsNoLoss) {
  Upstream upstream(octahedron(), {.limits = {.idle_time = 200ms}});
  RunningRelay relay({.relay = {.upstreams = {upstream.endpoint()},
                                .patience = 5s,
                                .least_backoff = 20s,
                                .most_backoff = 20s}});
  WebSocketClient client(relay.http());
  EXPECT_TRUE(is_welcome(greeted(client)));
  for (std::uint64_t id = 1; id <= 3; ++id) {
    open(client, id);
    EXPECT_TRUE(is_complete(end_of_stream(client))) << id;
    std::this_thread::sleep_for(400ms);
  }
}

// Counts the lists that a server gave.
class ListCount : public ServiceObserver {
 public:
  void request_ended(const ClientFacts&, const RequestFacts& facts) override {
    if (std::string_view(facts.kind) == "list") ++lists;
  }
  std::atomic<int> lists = 0;
};

TEST(GuardedRelay, AsksOnceForAllWhoComeAtTheSameTime) {
  const auto count = std::make_shared<ListCount>();
  Upstream upstream(octahedron(), {.keeper = {.observer = count}});
  RunningRelay relay({.relay = {.upstreams = {upstream.endpoint()}, .list_lifetime = 1h}});
  std::vector<std::unique_ptr<WebSocketClient>> clients;
  for (int i = 0; i < 20; ++i) clients.push_back(std::make_unique<WebSocketClient>(relay.http()));
  for (const auto& client : clients) client->send(Hello{});
  for (const auto& client : clients) EXPECT_TRUE(is_welcome(client->receive()));
  EXPECT_EQ(count->lists, 1);
}

}  // namespace
}  // namespace multitetra
