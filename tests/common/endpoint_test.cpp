#include "common/endpoint.hpp"

#include <gtest/gtest.h>

namespace multitetra {
namespace {

TEST(Endpoint, IsReadAsUsersWriteIt) {
  const std::vector<std::pair<std::string, Endpoint>> good = {
      {"localhost", {"localhost", kDefaultPort}},
      {"localhost:80", {"localhost", 80}},
      {"tcp://example.org", {"example.org", kDefaultPort}},
      {"tcp://example.org:7411", {"example.org", 7411}},
      {"127.0.0.1:0", {"127.0.0.1", 0}},
      {"0.0.0.0:65535", {"0.0.0.0", 65535}},
      {"[::1]", {"::1", kDefaultPort}},
      {"tcp://[fe80::1]:7410", {"fe80::1", 7410}}};
  for (const auto& [text, expected] : good) {
    const auto read = parse_endpoint(text);
    ASSERT_TRUE(read) << read.error().text;
    EXPECT_EQ(*read, expected) << text;
  }
}

TEST(Endpoint, WhatIsNoAddressIsRefusedWithAnExample) {
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

TEST(Endpoint, IsReadBackAsItIsWritten) {
  for (const Endpoint& endpoint :
       {Endpoint{"localhost", 80}, {"127.0.0.1", 0}, {"::1", 7410}, {"fe80::2", 65535}}) {
    EXPECT_EQ(*parse_endpoint(to_string(endpoint)), endpoint) << to_string(endpoint);
  }
  EXPECT_EQ(to_string(Endpoint{"::1", 7410}), "tcp://[::1]:7410");
}

}  // namespace
}  // namespace multitetra
