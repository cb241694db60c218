// The conversation over the WebSocket listener.
#include <chrono>

#include <gtest/gtest.h>

#include "tests/support/fake_steps.hpp"
#include "tests/support/running_http_server.hpp"

namespace multitetra {
namespace {

using namespace std::chrono_literals;
using testing::catalogue_of;
using testing::fake_catalogue;
using testing::FakeSteps;
using testing::heavy;
using testing::HttpClient;
using testing::kUpgradeFields;
using testing::RunningHttpServer;
using testing::WebSocketClient;
namespace websocket = boost::beast::websocket;

std::string upgrade_with(std::string_view more) {
  return std::string(kUpgradeFields) + "Sec-WebSocket-Protocol: multitetra.v1\r\n" +
         std::string(more);
}

// Returns all messages of one stream, including its StreamEnd.
std::vector<ServerMessage> stream(WebSocketClient& client, std::uint64_t id) {
  client.send(OpenStream{.request_id = id, .dataset = "octahedron", .cached_tile_digests = {}});
  std::vector<ServerMessage> messages;
  do {
    messages.push_back(client.receive());
  } while (!std::holds_alternative<StreamEnd>(messages.back()) &&
           !std::holds_alternative<ErrorReply>(messages.back()));
  return messages;
}

TEST(WebSocketListener, ExchangesTheSameMessagesAsTcp) {
  RunningHttpServer server(fake_catalogue("octahedron"));
  WebSocketClient client(server.http());
  EXPECT_EQ(client.response()[http::field::sec_websocket_protocol], "multitetra.v1");
  client.send(Hello{});
  EXPECT_EQ(client.receive_a<Welcome>().max_message_bytes, kMaxClientFrameBytes);
  client.send(ListDatasets{.request_id = 1});
  EXPECT_EQ(client.receive_a<DatasetList>().datasets.at(0).name, "octahedron");
  const auto messages = stream(client, 1);
  EXPECT_TRUE(std::holds_alternative<StepBegin>(messages.front()));
  EXPECT_EQ(std::get<StreamEnd>(messages.back()).outcome, StreamOutcome::kComplete);
  client.send(Ping{7});
  EXPECT_EQ(client.receive_a<Pong>().value, 7U);
}

TEST(WebSocketListener, SendsMessagesOfMegabytesInOneFrame) {
  RunningHttpServer server(
      catalogue_of(std::make_shared<FakeSteps>("octahedron", heavy(3, 5'000'000))));
  WebSocketClient client(server.http());
  client.send(Hello{});
  client.receive_a<Welcome>();
  const auto messages = stream(client, 1);
  EXPECT_TRUE(std::holds_alternative<StreamEnd>(messages.back()));
}

TEST(WebSocketListener, RequiresTheSubprotocol) {
  RunningHttpServer server(fake_catalogue("octahedron"));
  HttpClient client(server.http());
  const auto none = client.get("/v1/stream", kUpgradeFields);
  EXPECT_EQ(none.result_int(), 400U);
  EXPECT_NE(none.body().find("multitetra.v1"), std::string::npos);
  const auto other =
      client.get("/v1/stream", std::string(kUpgradeFields) + "Sec-WebSocket-Protocol: chat\r\n");
  EXPECT_EQ(other.result_int(), 400U);
  EXPECT_EQ(client.get("/v1/stream").result_int(), 426U);
  EXPECT_EQ(client.get("/v1/stream", upgrade_with("")).result_int(), 101U);
}

TEST(WebSocketListener, RejectsPagesOfOtherOrigins) {
  RunningHttpServer server(fake_catalogue("octahedron"),
                           {.allowed_origins = {"https://example.org"}});
  HttpClient client(server.http());
  const auto from = [&](std::string_view origin) {
    return client.get("/v1/stream", upgrade_with("Origin: " + std::string(origin) + "\r\n"))
        .result_int();
  };
  EXPECT_EQ(from("https://evil.example"), 403U);
  EXPECT_EQ(from("null"), 403U);
  EXPECT_EQ(from("https://example.org"), 101U);
}

TEST(WebSocketListener, RejectsTextMessages) {
  RunningHttpServer server(fake_catalogue("octahedron"));
  WebSocketClient client(server.http());
  client.send_as_text(Hello{});
  EXPECT_EQ(client.receive_a<ErrorReply>().error.code, ErrorCode::kMalformedMessage);
  EXPECT_EQ(client.closed().code, websocket::close_code::normal);
}

TEST(WebSocketListener, LimitsMessagesBeforeHello) {
  RunningHttpServer server(fake_catalogue("octahedron"));
  WebSocketClient client(server.http());
  client.send(Hello{.agent = std::string(17 * 1024, 'a')});
  EXPECT_EQ(client.closed().code, websocket::close_code::too_big);

  WebSocketClient welcomed(server.http());
  welcomed.send(Hello{});
  welcomed.receive_a<Welcome>();
  OpenStream open{.request_id = 1, .dataset = "octahedron", .cached_tile_digests = {}};
  open.cached_tile_digests.resize(8000, ContentDigest{1, 2});  // 128 000 bytes.
  welcomed.send(open);
  EXPECT_TRUE(std::holds_alternative<StepBegin>(welcomed.receive()));
}

TEST(WebSocketListener, LimitsTheTimeForHello) {
  RunningHttpServer server(fake_catalogue("octahedron"),
                           {.connection = {.handshake_timeout = 50ms}});
  WebSocketClient client(server.http());
  EXPECT_EQ(client.receive_a<ErrorReply>().error.code, ErrorCode::kUnavailable);
  client.closed();
}

// Counts the connections that have ended.
class EndCount : public ServiceObserver {
 public:
  void disconnected(const ClientFacts& client, double) override {
    if (std::string_view(client.protocol) == "websocket") ++ended;
  }
  testing::Count ended;
};

TEST(WebSocketListener, ClosesClientsThatDoNotRead) {
  const auto count = std::make_shared<EndCount>();
  RunningHttpServer server(
      catalogue_of(std::make_shared<FakeSteps>("octahedron", heavy(64, 1'000'000))),
      {.connection = {.write_timeout = 100ms, .linger = 10ms, .send_buffer_bytes = 64 * 1024}},
      {.admission = {.observer = count}});
  WebSocketClient client(server.http());
  client.send(Hello{});
  client.receive_a<Welcome>();
  client.send(OpenStream{.request_id = 1, .dataset = "octahedron", .cached_tile_digests = {}});
  ASSERT_TRUE(count->ended.reaches(1));
  EXPECT_NE(client.closed().code, websocket::close_code::normal);
}

TEST(WebSocketListener, NotifiesClientsOfAShutdown) {
  RunningHttpServer server(fake_catalogue("octahedron"));
  WebSocketClient client(server.http());
  client.send(Hello{});
  client.receive_a<Welcome>();
  std::thread stopping([&] { server.stop(); });
  EXPECT_EQ(client.receive_a<ErrorReply>().error.code, ErrorCode::kUnavailable);
  EXPECT_EQ(client.closed().code, websocket::close_code::normal);
  stopping.join();
}

TEST(WebSocketListener, StopsStreamsOfDisconnectedClients) {
  testing::Count running;
  RunningHttpServer server(
      catalogue_of(std::make_shared<FakeSteps>("octahedron", testing::endless(running))));
  {
    WebSocketClient client(server.http());
    client.send(Hello{});
    client.receive_a<Welcome>();
    client.send(OpenStream{.request_id = 1, .dataset = "octahedron", .cached_tile_digests = {}});
    ASSERT_TRUE(running.reaches(1));
  }
  EXPECT_TRUE(running.reaches(0));
}

}  // namespace
}  // namespace multitetra
