// How the client handles faulty servers.
#include "client/library/client.hpp"

#include <chrono>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "common/base/utf8.hpp"
#include "tests/client/scripted_server.hpp"
#include "tests/support/octahedra.hpp"

namespace multitetra {
namespace {

using testing::framed;
using testing::framed_messages;
using testing::ScriptedServer;
using testing::ThenTheServer;
using Messages = std::vector<ServerMessage>;

MessageSocket connected_to(const ScriptedServer& server,
                           std::chrono::milliseconds timeout = std::chrono::seconds(30)) {
  auto socket = MessageSocket::connect(server.endpoint(), timeout);
  if (!socket) throw std::runtime_error(socket.error().text);
  return *std::move(socket);
}

// A valid message follows each invalid one and must not be returned.
TEST(MessageSocket, ClosesAfterAnyError) {
  const std::string good = framed_messages(Messages{Pong{1}});
  const std::vector<std::pair<std::string, ErrorCode>> bad = {
      {frame_header(0) + good, ErrorCode::kMalformedFrame},
      {frame_header(kMaxServerFrameBytes + 1) + good, ErrorCode::kMessageTooLarge},
      {framed("no protobuf!") + good, ErrorCode::kMalformedMessage},
      {framed_messages(Messages{StepEnd{.request_id = 0}}) + good, ErrorCode::kInvalidArgument}};
  for (const auto& [bytes, code] : bad) {
    SCOPED_TRACE(std::string(name(code)));
    const ScriptedServer server(bytes);
    MessageSocket socket = connected_to(server);
    const auto first = socket.receive();
    ASSERT_FALSE(first);
    EXPECT_EQ(first.error().code, code);
    EXPECT_TRUE(server.client_leaves());
    const auto second = socket.receive();
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().code, ErrorCode::kUnavailable);
    const auto sent = socket.send(Ping{1});
    ASSERT_FALSE(sent);
    EXPECT_EQ(sent.error().code, ErrorCode::kUnavailable);
  }
}

TEST(MessageSocket, ClosesAfterALostRead) {
  const ScriptedServer server("", ThenTheServer::kHangsUp);
  MessageSocket socket = connected_to(server);
  const auto lost = socket.receive();
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().code, ErrorCode::kUnavailable);
  EXPECT_TRUE(server.client_leaves());
}

TEST(MessageSocket, TimesOutOnASilentServer) {
  const ScriptedServer server("");
  MessageSocket socket = connected_to(server, std::chrono::milliseconds(100));
  const auto silent = socket.receive();
  ASSERT_FALSE(silent);
  EXPECT_EQ(silent.error().code, ErrorCode::kUnavailable);
  EXPECT_NE(silent.error().text.find("within 0.1 s"), std::string::npos) << silent.error().text;
  EXPECT_TRUE(server.client_leaves());
}

// A server that sends some bytes, then others again and again.
class RepeatingServer {
 public:
  RepeatingServer(std::string first, std::string repeated)
      : thread_([this, first = std::move(first), repeated = std::move(repeated)] {
          tcp::socket socket = acceptor_.accept();
          boost::system::error_code error;
          asio::write(socket, asio::buffer(first), error);
          while (!error) {
            asio::write(socket, asio::buffer(repeated), error);
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
          }
        }) {}
  [[nodiscard]] Endpoint endpoint() const {
    return {.host = "127.0.0.1", .port = acceptor_.local_endpoint().port()};
  }

 private:
  asio::io_context io_;
  tcp::acceptor acceptor_{io_, {asio::ip::make_address("127.0.0.1"), 0}};
  std::jthread thread_;
};

TEST(MessageSocket, TimesOutWhenOnlyPongsArrive) {
  // A frame of a megabyte begins after some Pongs.
  const RepeatingServer server(framed_messages(Messages(20, Pong{})) + frame_header(1 << 20), "x");
  auto socket = MessageSocket::connect(server.endpoint(), std::chrono::milliseconds(300));
  ASSERT_TRUE(socket);
  Result<std::optional<ServerMessage>> message = std::nullopt;
  while (message) message = socket->receive_within(std::chrono::seconds(10));
  EXPECT_EQ(message.error().code, ErrorCode::kUnavailable);
  EXPECT_NE(message.error().text.find("made no progress within 3 s"), std::string::npos)
      << message.error().text;
}

TEST(Client, GivesUpOnAServerThatOnlySendsPongs) {
  const RepeatingServer server(framed_messages(Messages{Welcome{.version = kProtocolVersion}}),
                               framed_messages(Messages{Pong{}}));
  auto client = Client::connect(server.endpoint(), {.timeout = std::chrono::milliseconds(300)});
  ASSERT_TRUE(client);
  const auto list = client->list_datasets();
  ASSERT_FALSE(list);
  EXPECT_EQ(list.error().error.code, ErrorCode::kUnavailable);
  EXPECT_NE(list.error().error.text.find("made no progress within 0.3 s"), std::string::npos)
      << list.error().error.text;
}

TEST(Client, GivesUpOnAListByteByByte) {
  const RepeatingServer server(
      framed_messages(Messages{Welcome{.version = kProtocolVersion}}) + frame_header(1 << 20), "x");
  auto client = Client::connect(server.endpoint(), {.timeout = std::chrono::milliseconds(300)});
  ASSERT_TRUE(client);
  EXPECT_FALSE(client->list_datasets());
}

TEST(Client, LimitsTheTimeOfARequest) {
  const RepeatingServer server(framed_messages(Messages{Welcome{.version = kProtocolVersion}}),
                               framed_messages(Messages{Pong{}}));
  auto client =
      Client::connect(server.endpoint(), {.request_time = std::chrono::milliseconds(200)});
  ASSERT_TRUE(client);
  const auto list = client->list_datasets();
  ASSERT_FALSE(list);
  EXPECT_EQ(list.error().error.code, ErrorCode::kLimitExceeded);
}

TEST(Client, RefusesAListWhosePagesDoNotEnd) {
  const DatasetInfo info = testing::octahedra_info();
  const DatasetList page{.request_id = 1, .datasets = {info}, .next = info.name};
  const ScriptedServer server(
      framed_messages(Messages{Welcome{.version = kProtocolVersion}, page, page}));
  auto client = Client::connect(server.endpoint(), {});
  ASSERT_TRUE(client);
  const auto list = client->list_datasets();
  ASSERT_FALSE(list);
  EXPECT_EQ(list.error().error.code, ErrorCode::kDamagedData);
}

TEST(Client, ReportsServerErrorsAsOneShortPlainLine) {
  const std::string hostile =
      "\x1b[2Jgone\r\nmultitetra: all is well\n" + std::string(100'000, 'a');
  const ScriptedServer server(
      framed_messages(Messages{ErrorReply{.error = {ErrorCode::kInternal, hostile}}}));
  const auto refused = Client::connect(server.endpoint(), {});
  ASSERT_FALSE(refused);
  const std::string& text = refused.error().error.text;
  EXPECT_TRUE(is_plain_text(text));
  EXPECT_TRUE(text.starts_with("\\x1b[2Jgone\\x0d\\x0amultitetra")) << text;
  EXPECT_LE(text.size(), 1000U);
}

TEST(Client, RejectsServersWithAnotherProtocolVersion) {
  for (const std::uint32_t version : {kProtocolVersion, kProtocolVersion + 1}) {
    const ScriptedServer server(framed_messages(Messages{Welcome{.version = version}}));
    const auto client = Client::connect(server.endpoint(), {});
    ASSERT_EQ(client.has_value(), version == kProtocolVersion);
    if (client) continue;
    EXPECT_EQ(client.error().source, ErrorSource::kServer);
    EXPECT_EQ(client.error().error.code, ErrorCode::kUnsupportedVersion);
    EXPECT_TRUE(server.client_leaves());
  }
}

// A stream may end while a Ping is under way.
TEST(Client, IgnoresALatePong) {
  const ScriptedServer server(framed_messages(
      Messages{Welcome{.version = kProtocolVersion}, Pong{1}, DatasetList{.request_id = 1}}));
  auto client = Client::connect(server.endpoint(), {});
  ASSERT_TRUE(client);
  EXPECT_TRUE(client->list_datasets());
}

TEST(Retries, WaitForTheServersDelay) {
  std::vector<std::chrono::milliseconds> waits;
  Retries retries({.most = 2,
                   .first_wait = std::chrono::milliseconds(1),
                   .on_retry = [&](const Retry& retry) { waits.push_back(retry.wait); }});
  EXPECT_TRUE(retries.wait_after({ErrorCode::kUnavailable, "It is busy."}));
  EXPECT_TRUE(retries.wait_after(
      {.code = ErrorCode::kUnavailable, .text = "It is busy.", .retry_after = 0.03}));
  ASSERT_EQ(waits.size(), 2U);
  EXPECT_LT(waits[0], waits[1]);
  EXPECT_EQ(waits[1], std::chrono::milliseconds(30));
}

}  // namespace
}  // namespace multitetra
