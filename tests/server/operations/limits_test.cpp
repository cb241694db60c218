#include <gtest/gtest.h>

#include "server/operations/byte_reservations.hpp"
#include "server/operations/client_address.hpp"
#include "server/operations/connection_limiter.hpp"
#include "server/operations/request_rate.hpp"

namespace multitetra {
namespace {

// ---- requests per second

TEST(RequestRate, AllowsABurstThenTheRate) {
  RatePerName rate({.per_second = 10, .burst = 3});
  for (int i = 0; i < 3; ++i) EXPECT_EQ(rate.take("a", 0), 0);
  EXPECT_GT(rate.take("a", 0), 0);
  EXPECT_GT(rate.take("a", 0.09), 0);
  EXPECT_EQ(rate.take("a", 0.11), 0);
  int allowed = 0;
  for (int i = 0; i < 10'000; ++i) allowed += rate.take("a", 1 + 0.001 * i) <= 0 ? 1 : 0;
  EXPECT_NEAR(allowed, 103, 1);  // Ten seconds, plus the burst saved up before.
}

TEST(RequestRate, ReturnsTheDelay) {
  RatePerName rate({.per_second = 2, .burst = 1});
  EXPECT_EQ(rate.take("a", 0), 0);
  EXPECT_DOUBLE_EQ(rate.take("a", 0.1), 0.4);
  EXPECT_EQ(rate.take("a", 0.51), 0);
}

TEST(RequestRate, ChargesRejectedLargeRequests) {
  RatePerName rate({.per_second = 10, .burst = 20});
  EXPECT_EQ(rate.take("a", 0, 21), 0);
  EXPECT_NEAR(rate.take("a", 0), 0.2, 1e-9);
  EXPECT_NEAR(rate.take("a", 0, 21), 2.2, 1e-9) << "to look at it was work";
  for (int i = 0; i < 1000; ++i) EXPECT_LE(rate.take("a", 0, 21), 31) << "but no debt is for ever";
}

TEST(RequestRate, LimitsNamesSeparately) {
  RatePerName rate({.per_second = 1, .burst = 1});
  EXPECT_EQ(rate.take("a", 0), 0);
  EXPECT_GT(rate.take("a", 0), 0);
  EXPECT_EQ(rate.take("b", 0), 0);
}

TEST(RequestRate, TreatsZeroAsNoLimit) {
  RatePerName rate({.per_second = 0, .burst = 1});
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(rate.take("a", 0), 0);
  EXPECT_EQ(rate.size(), 0U);
}

TEST(RequestRate, GrantsNothingIfTheClockStopsOrGoesBack) {
  RatePerName rate({.per_second = 1, .burst = 1});
  EXPECT_EQ(rate.take("a", 10), 0);
  EXPECT_GT(rate.take("a", 5), 0);
  EXPECT_GT(rate.take("a", 10.5), 0);
  EXPECT_EQ(rate.take("a", 11), 0);
}

TEST(RequestRate, RemovesIdleNamesAndBoundsTheirNumber) {
  RatePerName rate({.per_second = 10, .burst = 2}, /*max_names=*/1000);
  for (int i = 0; i < 500; ++i) EXPECT_EQ(rate.take("a" + std::to_string(i), 0), 0);
  for (int i = 0; i < 500; ++i) EXPECT_EQ(rate.take("b" + std::to_string(i), 5), 0);
  EXPECT_LE(rate.size(), 600U);
  for (int i = 0; i < 100'000; ++i) (void)rate.take("c" + std::to_string(i), 10);
  EXPECT_LE(rate.size(), 1000U);
}

TEST(RequestRate, SharesOneAllowanceAmongTooManyNames) {
  RatePerName rate({.per_second = 1, .burst = 1}, /*max_names=*/2);
  EXPECT_EQ(rate.take("a", 0), 0);
  EXPECT_EQ(rate.take("b", 0), 0);
  EXPECT_EQ(rate.take("c", 0), 0);
  EXPECT_GT(rate.take("d", 0), 0);
  EXPECT_EQ(rate.take("a", 1.5), 0) << "A known name keeps its own allowance.";
}

// ---- connections

TEST(ConnectionLimiter, LimitsConnectionsInTotalAndPerName) {
  ConnectionLimiter connections({.total = 3, .per_name = 2});
  auto a1 = connections.acquire("a");
  auto a2 = connections.acquire("a");
  ASSERT_TRUE(a1 && a2);
  const auto a3 = connections.acquire("a");
  ASSERT_FALSE(a3);
  EXPECT_EQ(a3.error().code, ErrorCode::kUnavailable);
  EXPECT_NE(a3.error().text.find("2 connections from your address"), std::string::npos);
  auto b = connections.acquire("b");
  ASSERT_TRUE(b);
  const auto c = connections.acquire("c");
  ASSERT_FALSE(c);
  EXPECT_NE(c.error().text.find("limit of 3 connections"), std::string::npos);
  *a1 = {};
  EXPECT_EQ(connections.count(), 2U);
  EXPECT_TRUE(connections.acquire("a"));
  EXPECT_EQ(connections.count(), 2U) << "A discarded ticket is given back.";
}

TEST(ConnectionLimiter, CountsTrustedPeersInTheTotalOnly) {
  ConnectionLimiter connections({.total = 3, .per_name = 1});
  std::vector<ConnectionLimiter::Ticket> tickets;
  for (int i = 0; i < 3; ++i) tickets.push_back(*connections.acquire());
  EXPECT_FALSE(connections.acquire());
}

TEST(ConnectionLimiter, TreatsZeroAsNoLimit) {
  ConnectionLimiter connections({});
  std::vector<ConnectionLimiter::Ticket> tickets;
  for (int i = 0; i < 1000; ++i) tickets.push_back(*connections.acquire("a"));
  EXPECT_EQ(connections.count(), 1000U);
}

TEST(ByteReservations, ReleasesBytesOfShares) {
  ByteReservations budget(100);
  auto first = budget.take("a", 60);
  ASSERT_TRUE(first);
  EXPECT_FALSE(budget.take("b", 41));
  auto second = budget.take("b", 40);
  ASSERT_TRUE(second);
  ByteReservations::Reservation moved = *std::move(first);
  first.reset();
  EXPECT_EQ(budget.used(), 100U);
  moved = {};
  EXPECT_EQ(budget.used(), 40U);
}

TEST(ByteReservations, LeavesRoomForOtherShares) {
  ByteReservations budget(1000, /*max_share_fraction=*/0.25);
  EXPECT_EQ(budget.max_per_share(), 250U);
  EXPECT_FALSE(budget.take("a", 251));
  auto a = budget.take("a", 250);
  ASSERT_TRUE(a);
  EXPECT_FALSE(budget.take("a", 1));
  EXPECT_FALSE(budget.take("b", 188)) << "a quarter of the 750 bytes that are left";
  EXPECT_TRUE(budget.take("b", 187));
  a.reset();
  EXPECT_TRUE(budget.take("a", 250));
  EXPECT_EQ(budget.used(), 0U);
}

// Takes reservations of 1000 bytes for a share until one is refused.
std::vector<ByteReservations::Reservation> all_of(ByteReservations& budget,
                                                  const std::string& share) {
  std::vector<ByteReservations::Reservation> held;
  while (auto more = budget.take(share, 1000)) held.push_back(*std::move(more));
  return held;
}

TEST(ByteReservations, LeavesASixthAfterSixGreedyShares) {
  ByteReservations budget(1'000'000, 0.25);
  std::vector<std::vector<ByteReservations::Reservation>> held;
  for (int i = 0; i < 6; ++i)
    held.push_back(all_of(budget, "address 192.0.2." + std::to_string(i)));
  EXPECT_GT(budget.capacity() - budget.used(), budget.capacity() / 6);
  EXPECT_TRUE(budget.take("address 198.51.100.1", 40'000));
}

TEST(ByteReservations, CountsManySubnetsOfAnIpv6NetworkAsFewShares) {
  ByteReservations budget(1'000'000, 0.25);
  std::vector<std::vector<ByteReservations::Reservation>> held;
  const auto take_all_of = [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      char name[64];
      std::snprintf(name, sizeof name, "address 2001:db8:1:%x::/64", i);
      held.push_back(all_of(budget, name));
    }
    return budget.used();
  };
  EXPECT_LE(take_all_of(0, 256), 437'500U) << "a /56 has what two addresses have";
  EXPECT_LE(take_all_of(256, 4096), 684'000U) << "a /48 has what four have";
  EXPECT_TRUE(budget.take("address 192.0.2.7", 70'000));
  held.clear();
  EXPECT_EQ(budget.used(), 0U);
}

// ---- addresses

TEST(ClientAddress, GroupsLimitsByIpv4AddressOrIpv6Network) {
  EXPECT_EQ(limit_key("192.0.2.7"), "192.0.2.7");
  EXPECT_EQ(limit_key("::ffff:192.0.2.7"), "192.0.2.7");
  EXPECT_EQ(limit_key("2001:db8:1:2:3:4:5:6"), "2001:db8:1:2::/64");
  EXPECT_EQ(limit_key("2001:db8:1:2::"), limit_key("2001:db8:1:2:ffff::1"));
  EXPECT_NE(limit_key("2001:db8:1:2::"), limit_key("2001:db8:1:3::"));
  EXPECT_EQ(limit_key("unknown client"), "unknown client");
}

TEST(ShareLevels, NestIpv6Networks) {
  using Levels = std::vector<ShareLevel>;
  EXPECT_EQ(share_levels("address 192.0.2.7"), (Levels{{"address 192.0.2.7", 1}}));
  EXPECT_EQ(share_levels("token alice"), (Levels{{"token alice", 1}}));
  EXPECT_EQ(share_levels("token a/64"), (Levels{{"token a/64", 1}}));
  EXPECT_EQ(share_levels("address 2001:db8:1:203::/64"), (Levels{{"address 2001:db8:1:203::/64", 1},
                                                                 {"address 2001:db8:1:200::/56", 2},
                                                                 {"address 2001:db8:1::/48", 4}}));
  EXPECT_EQ(share_levels("gateway 192.0.2.1 address 2001:db8::/64").back().name,
            "gateway 192.0.2.1 address 2001:db8::/48");
}

AddressRanges ranges(const std::vector<std::string>& texts) {
  auto parsed = AddressRanges::parse(texts);
  EXPECT_TRUE(parsed) << parsed.error().text;
  return parsed ? *parsed : AddressRanges();
}
std::string client_of(std::string_view peer, std::string_view forwarded_for,
                      const std::vector<std::string>& trusted) {
  const ForwardedClient client = forwarded_client(peer, forwarded_for, ranges(trusted));
  return client.address + (client.is_trusted ? " trusted" : "");
}

TEST(ClientAddress, AcceptsForwardedAddressesOnlyFromTrustedProxies) {
  EXPECT_EQ(client_of("198.51.100.1", "203.0.113.5", {}), "198.51.100.1");
  EXPECT_EQ(client_of("10.0.0.1", "203.0.113.5", {"10.0.0.1"}), "203.0.113.5");
  EXPECT_EQ(client_of("::ffff:10.0.0.1", "203.0.113.5", {"10.0.0.1"}), "203.0.113.5");
  EXPECT_EQ(client_of("10.0.0.1", "", {"10.0.0.1"}), "10.0.0.1 trusted");
}

TEST(ClientAddress, IgnoresForwardedForFromClients) {
  const std::vector<std::string> trusted = {"10.0.0.1", "10.0.0.2"};
  EXPECT_EQ(client_of("10.0.0.1", "1.1.1.1, 203.0.113.5", trusted), "203.0.113.5");
  EXPECT_EQ(client_of("10.0.0.1", "1.1.1.1,203.0.113.5 , 10.0.0.2", trusted), "203.0.113.5");
  EXPECT_EQ(client_of("10.0.0.1", "10.0.0.2", trusted), "10.0.0.2 trusted");
}

TEST(ClientAddress, FallsBackToTheProxyForInvalidAddresses) {
  for (const std::string& hop :
       {std::string("garbage"), std::string("1.1.1.1, nonsense"), std::string(100'000, ','),
        std::string("203.0.113.5:"), std::string("203.0.113.5:99999"), std::string("[2001:db8::1"),
        std::string("203.0.113.5,")}) {
    EXPECT_EQ(client_of("10.0.0.1", hop, {"10.0.0.1"}), "10.0.0.1") << hop.substr(0, 40);
  }
}

TEST(ClientAddress, ParsesPortsAndBracketsOfHops) {
  EXPECT_EQ(client_of("10.0.0.1", "203.0.113.5:4711", {"10.0.0.1"}), "203.0.113.5");
  EXPECT_EQ(client_of("10.0.0.1", "[2001:db8::7]:4711", {"10.0.0.1"}), "2001:db8::7");
  EXPECT_EQ(client_of("10.0.0.1", "[2001:db8::7]", {"10.0.0.1"}), "2001:db8::7");
  EXPECT_EQ(client_of("10.0.0.1", "2001:db8::7", {"10.0.0.1"}), "2001:db8::7");
}

TEST(ClientAddress, TrustsAllAddressesOfANetwork) {
  const AddressRanges trusted = ranges({"10.1.0.0/16", "2001:db8::/33", "192.0.2.7"});
  for (const char* in : {"10.1.255.3", "::ffff:10.1.0.1", "2001:db8:7fff::1", "192.0.2.7"}) {
    EXPECT_TRUE(trusted.contains(in)) << in;
  }
  for (const char* out : {"10.2.0.1", "2001:db8:8000::1", "192.0.2.8", "localhost", ""}) {
    EXPECT_FALSE(trusted.contains(out)) << out;
  }
  EXPECT_TRUE(ranges({"0.0.0.0/0"}).contains("203.0.113.5"));
  EXPECT_FALSE(ranges({"0.0.0.0/0"}).contains("2001:db8::1"));
}

TEST(ClientAddress, RejectsInvalidNetworks) {
  for (const char* text :
       {"localhost", "", "10.0.0.0/33", "10.0.0.0/-1", "10.0.0.0/", "10.0.0.0/8x", "::/129"}) {
    const auto refused = AddressRanges::parse({"10.0.0.1", text});
    ASSERT_FALSE(refused) << text;
    EXPECT_NE(refused.error().text.find('"' + std::string(text) + '"'), std::string::npos);
  }
}

}  // namespace
}  // namespace multitetra
