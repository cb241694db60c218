#include <gtest/gtest.h>

#include "server/operations/byte_reservations.hpp"
#include "server/operations/client_address.hpp"
#include "server/operations/connection_limiter.hpp"
#include "server/operations/request_rate.hpp"

namespace multitetra {
namespace {

// ---- requests a second

TEST(RequestRate, AllowsABurstThenSoManyASecond) {
  RatePerName rate({.per_second = 10, .burst = 3});
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(rate.take("a", 0));
  EXPECT_FALSE(rate.take("a", 0));
  EXPECT_FALSE(rate.take("a", 0.09));
  EXPECT_TRUE(rate.take("a", 0.11));
  int allowed = 0;
  for (int i = 0; i < 10'000; ++i) allowed += rate.take("a", 1 + 0.001 * i) ? 1 : 0;
  EXPECT_NEAR(allowed, 103, 1);  // Ten seconds, and what was saved up before.
}

TEST(RequestRate, OneNameTakesNothingFromAnother) {
  RatePerName rate({.per_second = 1, .burst = 1});
  EXPECT_TRUE(rate.take("a", 0));
  EXPECT_FALSE(rate.take("a", 0));
  EXPECT_TRUE(rate.take("b", 0));
}

TEST(RequestRate, ZeroIsNoLimit) {
  RatePerName rate({.per_second = 0, .burst = 1});
  for (int i = 0; i < 1000; ++i) EXPECT_TRUE(rate.take("a", 0));
  EXPECT_EQ(rate.size(), 0U);
}

TEST(RequestRate, AClockThatStandsStillOrGoesBackGivesNothing) {
  RatePerName rate({.per_second = 1, .burst = 1});
  EXPECT_TRUE(rate.take("a", 10));
  EXPECT_FALSE(rate.take("a", 5));
  EXPECT_FALSE(rate.take("a", 10.5));
  EXPECT_TRUE(rate.take("a", 11));
}

TEST(RequestRate, ForgetsWhoHasRestedAndNeverKnowsMoreThanItMay) {
  RatePerName rate({.per_second = 10, .burst = 2}, /*most_names=*/1000);
  for (int i = 0; i < 500; ++i) EXPECT_TRUE(rate.take("a" + std::to_string(i), 0));
  for (int i = 0; i < 500; ++i) EXPECT_TRUE(rate.take("b" + std::to_string(i), 5));
  EXPECT_LE(rate.size(), 600U);
  for (int i = 0; i < 100'000; ++i) (void)rate.take("c" + std::to_string(i), 10);
  EXPECT_LE(rate.size(), 1000U);
}

TEST(RequestRate, WhenThereAreTooManyNamesNewcomersShareOneAllowance) {
  RatePerName rate({.per_second = 1, .burst = 1}, /*most_names=*/2);
  EXPECT_TRUE(rate.take("a", 0));
  EXPECT_TRUE(rate.take("b", 0));
  EXPECT_TRUE(rate.take("c", 0));
  EXPECT_FALSE(rate.take("d", 0));
  EXPECT_TRUE(rate.take("a", 1.5)) << "Who is known keeps an allowance of its own.";
}

// ---- connections

TEST(ConnectionLimiter, CountThoseInsideInAllAndByName) {
  ConnectionLimiter connections({.total = 3, .per_name = 2});
  auto a1 = connections.enter("a");
  auto a2 = connections.enter("a");
  ASSERT_TRUE(a1 && a2);
  const auto a3 = connections.enter("a");
  ASSERT_FALSE(a3);
  EXPECT_EQ(a3.error().code, ErrorCode::kUnavailable);
  EXPECT_NE(a3.error().text.find("2 connections from your address"), std::string::npos);
  auto b = connections.enter("b");
  ASSERT_TRUE(b);
  const auto c = connections.enter("c");
  ASSERT_FALSE(c);
  EXPECT_NE(c.error().text.find("has its 3 connections"), std::string::npos);
  *a1 = {};
  EXPECT_EQ(connections.inside(), 2U);
  EXPECT_TRUE(connections.enter("a"));
  EXPECT_EQ(connections.inside(), 2U) << "A ticket that nobody keeps is given back.";
}

TEST(ConnectionLimiter, WhoIsTrustedCountsInAllOnly) {
  ConnectionLimiter connections({.total = 3, .per_name = 1});
  std::vector<ConnectionLimiter::Ticket> tickets;
  for (int i = 0; i < 3; ++i) tickets.push_back(*connections.enter());
  EXPECT_FALSE(connections.enter());
}

TEST(ConnectionLimiter, ZeroIsNoLimit) {
  ConnectionLimiter connections({});
  std::vector<ConnectionLimiter::Ticket> tickets;
  for (int i = 0; i < 1000; ++i) tickets.push_back(*connections.enter("a"));
  EXPECT_EQ(connections.inside(), 1000U);
}

TEST(ByteReservations, GivesBackWhatSharesHeld) {
  ByteReservations budget(100);
  auto first = budget.take(60);
  ASSERT_TRUE(first);
  EXPECT_FALSE(budget.take(41));
  auto second = budget.take(40);
  ASSERT_TRUE(second);
  ByteReservations::Reservation moved = *std::move(first);
  first.reset();
  EXPECT_EQ(budget.used(), 100U);
  moved = {};
  EXPECT_EQ(budget.used(), 40U);
}

// ---- addresses

TEST(ClientAddress, LimitsHoldForAnIpv4AddressOrAnIpv6Network) {
  EXPECT_EQ(limited_name("192.0.2.7"), "192.0.2.7");
  EXPECT_EQ(limited_name("::ffff:192.0.2.7"), "192.0.2.7");
  EXPECT_EQ(limited_name("2001:db8:1:2:3:4:5:6"), "2001:db8:1:2::/64");
  EXPECT_EQ(limited_name("2001:db8:1:2::"), limited_name("2001:db8:1:2:ffff::1"));
  EXPECT_NE(limited_name("2001:db8:1:2::"), limited_name("2001:db8:1:3::"));
  EXPECT_EQ(limited_name("unknown client"), "unknown client");
}

TEST(ClientAddress, OnlyTrustedProxiesSayWhoIsBehindThem) {
  EXPECT_EQ(client_behind("198.51.100.1", "203.0.113.5", {}), "198.51.100.1");
  EXPECT_EQ(client_behind("10.0.0.1", "203.0.113.5", {"10.0.0.1"}), "203.0.113.5");
  EXPECT_EQ(client_behind("::ffff:10.0.0.1", "203.0.113.5", {"10.0.0.1"}), "203.0.113.5");
}

TEST(ClientAddress, WhatAClientSaysOfItselfDoesNotCount) {
  const std::vector<std::string> trusted = {"10.0.0.1", "10.0.0.2"};
  EXPECT_EQ(client_behind("10.0.0.1", "1.1.1.1, 203.0.113.5", trusted), "203.0.113.5");
  EXPECT_EQ(client_behind("10.0.0.1", "1.1.1.1,203.0.113.5 , 10.0.0.2", trusted), "203.0.113.5");
  EXPECT_EQ(client_behind("10.0.0.1", "", trusted), "10.0.0.1");
  EXPECT_EQ(client_behind("10.0.0.1", "1.1.1.1, nonsense", trusted), "10.0.0.1");
  EXPECT_EQ(client_behind("10.0.0.1", "10.0.0.2", trusted), "10.0.0.2");
  EXPECT_EQ(client_behind("10.0.0.1", std::string(100'000, ','), trusted), "10.0.0.1");
}

}  // namespace
}  // namespace multitetra
