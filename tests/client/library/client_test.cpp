// What the client makes of servers that are wrong.
#include "client/library/client.hpp"

#include <chrono>
#include <vector>

#include <gtest/gtest.h>

#include "tests/client/scripted_server.hpp"

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

// A good message follows each bad one: nothing of it may come out any more.
TEST(MessageSocket, AfterAnyErrorTheConnectionIsClosed) {
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

TEST(MessageSocket, AfterALostReadTheConnectionIsClosed) {
  const ScriptedServer server("", ThenTheServer::kHangsUp);
  MessageSocket socket = connected_to(server);
  const auto lost = socket.receive();
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().code, ErrorCode::kUnavailable);
  EXPECT_TRUE(server.client_leaves());
}

TEST(MessageSocket, ASilentServerIsLeftAfterTheTimeout) {
  const ScriptedServer server("");
  MessageSocket socket = connected_to(server, std::chrono::milliseconds(100));
  const auto silent = socket.receive();
  ASSERT_FALSE(silent);
  EXPECT_EQ(silent.error().code, ErrorCode::kUnavailable);
  EXPECT_NE(silent.error().text.find("within 0.1 s"), std::string::npos) << silent.error().text;
  EXPECT_TRUE(server.client_leaves());
}

TEST(Client, LeavesAServerThatSpeaksAnotherVersion) {
  for (const std::uint32_t version : {kProtocolVersion, kProtocolVersion + 1}) {
    const ScriptedServer server(framed_messages(Messages{Welcome{.version = version}}));
    const auto client = Client::connect(server.endpoint(), {});
    ASSERT_EQ(client.has_value(), version == kProtocolVersion);
    if (client) continue;
    EXPECT_EQ(client.error().trouble, Trouble::kServer);
    EXPECT_EQ(client.error().error.code, ErrorCode::kUnsupportedVersion);
    EXPECT_TRUE(server.client_leaves());
  }
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
