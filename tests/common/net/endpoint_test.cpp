#include "common/net/endpoint.hpp"

#include <gtest/gtest.h>

namespace multitetra {
namespace {

TEST(Endpoint, ParsesShortAndFullAddresses) {
  const std::vector<std::pair<std::string, Endpoint>> good = {
      {"localhost", {"localhost", kDefaultPort}},
      {"localhost:80", {"localhost", 80}},
      {"tcp://example.org", {"example.org", kDefaultPort}},
      {"tcp://example.org:7411", {"example.org", 7411}},
      {"127.0.0.1:0", {"127.0.0.1", 0}},
      {"9120", {"127.0.0.1", 9120}},
      {"tcp://0", {"127.0.0.1", 0}},
      {"0.0.0.0:65535", {"0.0.0.0", 65535}},
      {"[::1]", {"::1", kDefaultPort}},
      {"tcp://[fe80::1]:7410", {"fe80::1", 7410}}};
  for (const auto& [text, expected] : good) {
    const auto read = parse_endpoint(text);
    ASSERT_TRUE(read) << read.error().text;
    EXPECT_EQ(*read, expected) << text;
  }
}

TEST(Endpoint, RejectsInvalidAddressesWithAnExample) {
  for (const std::string text : {"",
                                 "tcp://",
                                 ":80",
                                 "tcp://:80",
                                 "host:",
                                 "host:port",
                                 "host:-1",
                                 "host:+1",
                                 "host:65536",
                                 "host:80:81",
                                 "host:80/",
                                 "host/path",
                                 "http://example.org",
                                 "udp://example.org:1",
                                 "::1",
                                 "fe80::1:80",
                                 "[::1",
                                 "[]:80",
                                 "[::1]80",
                                 "[::1]:",
                                 "[::1]:x"}) {
    const auto read = parse_endpoint(text);
    ASSERT_FALSE(read) << text;
    EXPECT_EQ(read.error().code, ErrorCode::kInvalidArgument);
    EXPECT_NE(read.error().text.find("\"" + text + "\""), std::string::npos) << read.error().text;
    EXPECT_NE(read.error().text.find("tcp://127.0.0.1:7410"), std::string::npos);
  }
}

TEST(ServerUrl, SelectsTheTransport) {
  const std::vector<std::pair<std::string, Endpoint>> good = {
      {"localhost", {"localhost", kDefaultPort}},
      {"tcp://[::1]:80", {"::1", 80}},
      {"tls://example.org", {"example.org", kDefaultPort, Transport::kTls}},
      {"ws://example.org", {"example.org", 80, Transport::kWebSocket, "/v1/stream"}},
      {"wss://site.org/a/b/", {"site.org", 443, Transport::kSecureWebSocket, "/a/b/v1/stream"}},
      {"ws://example.org/", {"example.org", 80, Transport::kWebSocket, "/v1/stream"}},
      {"ws://[::1]:7480/v1/stream", {"::1", 7480, Transport::kWebSocket, "/v1/stream"}},
      {"http://127.0.0.1:7480/", {"127.0.0.1", 7480, Transport::kWebSocket, "/v1/stream"}},
      {"https://example.org", {"example.org", 443, Transport::kSecureWebSocket, "/v1/stream"}},
      {"wss://example.org", {"example.org", 443, Transport::kSecureWebSocket, "/v1/stream"}},
      {"wss://a:1/heads/v1/stream?x=1",
       {"a", 1, Transport::kSecureWebSocket, "/heads/v1/stream?x=1"}}};
  for (const auto& [text, expected] : good) {
    const auto read = parse_server_url(text);
    ASSERT_TRUE(read) << read.error().text;
    EXPECT_EQ(*read, expected) << text;
    EXPECT_EQ(*parse_server_url(to_string(*read)), *read);
  }
}

TEST(ServerUrl, RejectsInvalidUrls) {
  for (const std::string text :
       {"ftp://example.org", "ws://", "ws:///v1/stream", "wss://:443", "ws://a:/", "ws://a:1x/",
        "ws://a/b c", "ws://a/\r\nHost: b", "tls://a/path", "tcp://a:1/v1/stream", "WS://a"}) {
    const auto read = parse_server_url(text);
    ASSERT_FALSE(read) << text;
    EXPECT_EQ(read.error().code, ErrorCode::kInvalidArgument);
  }
}

TEST(Endpoint, ListensOnTcpOnly) {
  for (const std::string text : {"tls://a:1", "ws://a:1", "wss://a:1/v1/stream"}) {
    EXPECT_FALSE(parse_endpoint(text)) << text;
  }
}

TEST(Endpoint, RoundTrips) {
  for (const Endpoint& endpoint :
       {Endpoint{"localhost", 80}, {"127.0.0.1", 0}, {"::1", 7410}, {"fe80::2", 65535}}) {
    EXPECT_EQ(*parse_endpoint(to_string(endpoint)), endpoint) << to_string(endpoint);
  }
  EXPECT_EQ(to_string(Endpoint{"::1", 7410}), "tcp://[::1]:7410");
}

TEST(Endpoint, RecognizesLoopbackAsThisMachine) {
  for (const char* host : {"localhost", "127.0.0.1", "127.1.2.3", "::1"}) {
    EXPECT_TRUE(is_this_machine(host)) << host;
  }
  for (const char* host : {"0.0.0.0", "::", "192.168.1.2", "example.org", "localhost.example.org",
                           "fe80::1", "", "128.0.0.1"}) {
    EXPECT_FALSE(is_this_machine(host)) << host;
  }
}

}  // namespace
}  // namespace multitetra
