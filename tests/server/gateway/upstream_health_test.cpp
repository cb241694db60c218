// Failures and recoveries of servers, at times chosen by the tests.
#include "server/gateway/detail/upstream_health.hpp"

#include <gtest/gtest.h>

namespace multitetra {
namespace {

using namespace std::chrono_literals;
using Change = UpstreamHealth::Change;

constexpr UpstreamHealth::Clock::time_point kStart{1h};

TEST(UpstreamHealth, IsUnknownForAnUntriedServer) {
  const UpstreamHealth health(100ms, 1s);
  EXPECT_FALSE(health.is_reachable(kStart));
  EXPECT_FALSE(health.has_failed());
  EXPECT_TRUE(health.may_be_tried(kStart));
}

TEST(UpstreamHealth, ReportsEachChangeOnce) {
  UpstreamHealth health(100ms, 1s);
  EXPECT_EQ(health.record_success(), Change::kReachable);
  EXPECT_EQ(health.record_success(), Change::kNone);
  EXPECT_EQ(health.record_failure(kStart), Change::kLost);
  EXPECT_EQ(health.record_failure(kStart), Change::kNone);
  EXPECT_EQ(health.record_success(), Change::kReachable);
  EXPECT_TRUE(health.is_reachable(kStart));
}

TEST(UpstreamHealth, QuarantinesAReachableServerThatSendsDamage) {
  UpstreamHealth health(100ms, 1s);
  health.record_success();
  EXPECT_EQ(health.quarantine(kStart, 60s), Change::kLost);
  EXPECT_EQ(health.quarantine(kStart, 60s), Change::kNone);
  health.record_success();
  EXPECT_FALSE(health.may_be_tried(kStart + 59s));
  EXPECT_FALSE(health.is_reachable(kStart + 59s));
  EXPECT_TRUE(health.may_be_tried(kStart + 60s));
  EXPECT_TRUE(health.is_reachable(kStart + 60s));
}

TEST(UpstreamHealth, ReportsAServerThatFailsAtOnce) {
  UpstreamHealth health(100ms, 1s);
  EXPECT_EQ(health.record_failure(kStart), Change::kLost);
  EXPECT_FALSE(health.is_reachable(kStart));
}

TEST(UpstreamHealth, DoublesTheWaitAfterEachFailureUpToTheMaximum) {
  UpstreamHealth health(100ms, 350ms);
  auto now = kStart;
  for (const auto wait : {100ms, 200ms, 350ms, 350ms}) {
    health.record_failure(now);
    EXPECT_EQ(health.next_try(), now + wait);
    EXPECT_FALSE(health.may_be_tried(now + wait - 1ms));
    EXPECT_TRUE(health.may_be_tried(now + wait));
    now += wait;
  }
}

TEST(UpstreamHealth, ResetsAfterRecovery) {
  UpstreamHealth health(100ms, 10s);
  for (int i = 0; i < 5; ++i) health.record_failure(kStart);
  health.record_success();
  EXPECT_TRUE(health.may_be_tried(kStart));
  health.record_failure(kStart);
  EXPECT_EQ(health.next_try(), kStart + 100ms);
}

}  // namespace
}  // namespace multitetra
