// Listeners that the client accepts, and listeners it must reject.
#include <gtest/gtest.h>

#include "client/library/client.hpp"
#include "tests/client/scripted_server.hpp"
#include "tests/client/transport_listener.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

using testing::framed_messages;
using testing::ListenerManners;
using testing::ScriptedServer;
using testing::ThenTheServer;
using testing::TransportListener;
using Messages = std::vector<ServerMessage>;
using std::chrono::milliseconds;

ClientResult<Client> connect(const Endpoint& server, const Trust& trust,
                             milliseconds timeout = std::chrono::seconds(30)) {
  return Client::connect(server, {.timeout = timeout, .trust = trust});
}

class ListenerTransport : public ::testing::TestWithParam<Transport> {};

TEST_P(ListenerTransport, DeliversMessagesUnchanged) {
  const std::string bytes = framed_messages(Messages{Welcome{}, DatasetList{.request_id = 1}});
  const ScriptedServer server(bytes);
  const TransportListener listener(GetParam(), server.endpoint());
  auto client = connect(listener.endpoint(), listener.trust());
  ASSERT_TRUE(client) << client.error().error.text;
  const auto datasets = client->list_datasets();
  ASSERT_TRUE(datasets) << datasets.error().error.text;
  EXPECT_TRUE(datasets->empty());
}

TEST_P(ListenerTransport, DeliversMessagesOfAnyLength) {
  Messages messages = {Welcome{}};
  for (const std::size_t size : {1U, 125U, 126U, 65'535U, 65'536U, 1'000'000U}) {
    messages.emplace_back(
        Tile{.request_id = 1, .payload = std::make_shared<const std::string>(size, '\xff')});
  }
  const ScriptedServer server(framed_messages(messages));
  const TransportListener listener(GetParam(), server.endpoint());
  auto client = connect(listener.endpoint(), listener.trust());
  ASSERT_TRUE(client) << client.error().error.text;
  for (std::size_t i = 1; i < messages.size(); ++i) {
    const auto received = client->receive_within(std::chrono::seconds(30));
    ASSERT_TRUE(received && *received);
    EXPECT_EQ(serialize(**received), serialize(messages[i]));
  }
}

TEST_P(ListenerTransport, TimesOutOnASilentServer) {
  const ScriptedServer server("");
  const TransportListener listener(GetParam(), server.endpoint());
  const auto client = connect(listener.endpoint(), listener.trust(), milliseconds(300));
  ASSERT_FALSE(client);
  EXPECT_EQ(client.error().error.code, ErrorCode::kUnavailable);
  EXPECT_TRUE(server.client_leaves());
}

// A wait that times out does not lose part of the message.
TEST_P(ListenerTransport, ReceivesEveryMessageByPolling) {
  const ScriptedServer server(framed_messages(Messages{
      Welcome{},
      Tile{.request_id = 1, .payload = std::make_shared<const std::string>(3'000'000, 'a')}}));
  const TransportListener listener(GetParam(), server.endpoint());
  auto client = connect(listener.endpoint(), listener.trust());
  ASSERT_TRUE(client) << client.error().error.text;
  for (;;) {
    const auto received = client->receive_within(milliseconds(0));
    ASSERT_TRUE(received) << received.error().error.text;
    if (*received) break;
  }
}

TEST_P(ListenerTransport, ClosesAfterAMessageAboveTheLimit) {
  const ScriptedServer server(framed_messages(
      Messages{Tile{.request_id = 1, .payload = std::make_shared<const std::string>(5'000, 'a')}}));
  const TransportListener listener(GetParam(), server.endpoint());
  const auto tls = client_tls(listener.trust());
  auto socket = MessageSocket::connect(listener.endpoint(), std::chrono::seconds(30),
                                       {.tls = *tls, .transport = {.max_message_bytes = 4'000}});
  ASSERT_TRUE(socket) << socket.error().text;
  const auto message = socket->receive();
  ASSERT_FALSE(message);
  EXPECT_EQ(message.error().code, ErrorCode::kMessageTooLarge);
  EXPECT_TRUE(server.client_leaves());
}

INSTANTIATE_TEST_SUITE_P(, ListenerTransport,
                         ::testing::Values(Transport::kTls, Transport::kWebSocket,
                                           Transport::kSecureWebSocket));

// ---- certificates

class TlsCertificates : public ::testing::TestWithParam<Transport> {
 protected:
  static std::string refusal_of(const TransportListener& listener, const std::string& host,
                                const Trust& trust) {
    const auto client = connect(listener.at(host), trust);
    if (client) return "";
    EXPECT_EQ(client.error().source, ErrorSource::kNetwork);
    EXPECT_EQ(client.error().error.code, ErrorCode::kInvalidArgument) << "trying again is no use";
    return client.error().error.text;
  }

  ScriptedServer server_{framed_messages(Messages{Welcome{}})};
};

TEST_P(TlsCertificates, RejectAnUnknownAuthority) {
  const TransportListener listener(GetParam(), server_.endpoint());
  const std::string refusal = refusal_of(listener, "127.0.0.1", {});
  EXPECT_NE(refusal.find("--ca"), std::string::npos) << refusal;
}

TEST_P(TlsCertificates, RejectAnotherHost) {
  for (const std::string names : {"DNS:example.org", "IP:127.0.0.2", "DNS:*.org,DNS:127.0.0.1"}) {
    const TransportListener listener(GetParam(), server_.endpoint(), {.certificate_names = names});
    for (const std::string host : {"127.0.0.1", "localhost"}) {
      const std::string refusal = refusal_of(listener, host, listener.trust());
      EXPECT_NE(refusal.find("is not valid for the name"), std::string::npos)
          << host << ": " << refusal;
    }
  }
}

TEST_P(TlsCertificates, AcceptTheHostAndItsAuthority) {
  const TransportListener listener(GetParam(), server_.endpoint(),
                                   {.certificate_names = "DNS:localhost"});
  EXPECT_EQ(refusal_of(listener, "localhost", listener.trust()), "");
}

TEST_P(TlsCertificates, AreIgnoredWithInsecure) {
  const TransportListener listener(GetParam(), server_.endpoint(),
                                   {.certificate_names = "DNS:example.org"});
  EXPECT_EQ(refusal_of(listener, "127.0.0.1", {.insecure = true}), "");
}

TEST_P(TlsCertificates, RejectAServerWithoutTls) {
  Endpoint plain = server_.endpoint();
  plain.transport = GetParam();
  const auto client = connect(plain, {.insecure = true});
  ASSERT_FALSE(client);
  EXPECT_EQ(client.error().source, ErrorSource::kNetwork);
}

INSTANTIATE_TEST_SUITE_P(, TlsCertificates,
                         ::testing::Values(Transport::kTls, Transport::kSecureWebSocket));

TEST(Trust, RejectsAFileWithoutCertificates) {
  const TemporaryFolder folder;
  for (const auto& file : {folder.file("empty.pem", ""), folder.path() / "missing.pem"}) {
    const auto tls = client_tls({.ca_file = file.string()});
    ASSERT_FALSE(tls);
    EXPECT_NE(tls.error().text.find(file.string()), std::string::npos);
  }
}

// ---- no server

TEST(ConnectRetries, ReachAServerThatStartsLater) {
  for (const Transport transport : {Transport::kTcp, Transport::kTls, Transport::kWebSocket}) {
    // Only root can listen on port 1.
    const auto none = connect({.host = "127.0.0.1", .port = 1, .transport = transport}, {});
    ASSERT_FALSE(none);
    const std::string& text = none.error().error.text;
    EXPECT_NE(text.find("Is the server running?"), std::string::npos) << text;
    // A TLS server needs more options than an address, so none are suggested.
    EXPECT_EQ(text.find("--tcp tcp://127.0.0.1:1") != std::string::npos,
              transport == Transport::kTcp)
        << text;
  }
}

// ---- WebSockets

TEST(WebSocketClient, ReportsTheServersRejection) {
  const ScriptedServer server("");
  const TransportListener lacking(Transport::kWebSocket, server.endpoint(), {.status = 404});
  const auto none = connect(lacking.endpoint(), {});
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().error.code, ErrorCode::kInvalidArgument);
  EXPECT_NE(none.error().error.text.find("404"), std::string::npos) << none.error().error.text;
  const TransportListener busy(Transport::kWebSocket, server.endpoint(), {.status = 503});
  const auto later = connect(busy.endpoint(), {});
  ASSERT_FALSE(later);
  EXPECT_EQ(later.error().error.code, ErrorCode::kUnavailable) << "it is tried again";
}

TEST(WebSocketClient, ClosesOtherProtocols) {
  const ScriptedServer server("");
  for (const std::string subprotocol : {"", "multitetra.v2"}) {
    const TransportListener listener(Transport::kWebSocket, server.endpoint(),
                                     {.subprotocol = subprotocol});
    const auto client = connect(listener.endpoint(), {});
    ASSERT_FALSE(client);
    EXPECT_EQ(client.error().error.code, ErrorCode::kUnsupportedVersion);
  }
}

TEST(WebSocketClient, ClosesOnTextMessages) {
  const ScriptedServer server(framed_messages(Messages{Welcome{}}));
  const TransportListener listener(Transport::kWebSocket, server.endpoint(),
                                   {.text_messages = true});
  const auto client = connect(listener.endpoint(), {});
  ASSERT_FALSE(client);
  EXPECT_NE(client.error().error.code, ErrorCode::kUnavailable);
}

}  // namespace
}  // namespace multitetra
