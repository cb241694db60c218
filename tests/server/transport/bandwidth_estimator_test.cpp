// Estimates for links of any speed, at times chosen by the tests.
#include "server/transport/bandwidth_estimator.hpp"

#include <gtest/gtest.h>

namespace multitetra {
namespace {

using namespace std::chrono_literals;

constexpr BandwidthEstimator::Clock::time_point kStart{1h};
constexpr double kSocket = 64 * 1024;  // Capacity of the send buffer.

// Returns the estimate after sending messages of `bytes` bytes over a link of the given rate.
double measured(double bytes_per_second, int messages, double bytes) {
  BandwidthEstimator rate;
  auto now = kStart;
  double waiting = 0;
  for (int i = 0; i < messages; ++i) {
    rate.write_begins(now, static_cast<std::uint64_t>(waiting));
    const double must_leave = std::max(0.0, waiting + bytes - kSocket);
    now += std::chrono::nanoseconds(static_cast<std::int64_t>(must_leave / bytes_per_second * 1e9));
    waiting += bytes - must_leave;
    rate.write_ends(now, static_cast<std::uint64_t>(bytes), static_cast<std::uint64_t>(waiting));
  }
  return rate.bytes_per_second();
}

TEST(BandwidthEstimator, StartsAtTenMegabitsASecond) {
  BandwidthEstimator rate;
  EXPECT_EQ(rate.bytes_per_second(), 1.25e6);
  rate.write_begins(kStart, 0);
  rate.write_ends(kStart + 1us, 30'000, 0);
  EXPECT_EQ(rate.bytes_per_second(), 1.25e6) << "some buffer took it";
}

TEST(BandwidthEstimator, MeasuresTheRateOfABottleneckLink) {
  for (const double link : {3e4, 1.25e5, 1.25e6, 1e7, 1e8}) {
    EXPECT_NEAR(measured(link, 100, 100'000), link, 0.05 * link);
  }
}

TEST(BandwidthEstimator, RatesLinksThatAcceptLargeBurstsAsFast) {
  BandwidthEstimator rate;
  rate.write_begins(kStart, 0);
  rate.write_ends(kStart + 1ms, 1'000'000, 0);
  EXPECT_NEAR(rate.bytes_per_second(), 1e9, 1e6);
}

TEST(BandwidthEstimator, SumsMessagesSentOneByOne) {
  BandwidthEstimator rate;
  for (int i = 0; i < 10; ++i) {
    rate.write_begins(kStart + i * 1s, 0);
    rate.write_ends(kStart + i * 1s + 1ms, 30'000, 0);
  }
  EXPECT_NEAR(rate.bytes_per_second(), 3e7, 1e3);
}

TEST(BandwidthEstimator, LowersTheRateWhenBytesWait) {
  BandwidthEstimator rate;
  rate.write_begins(kStart, 0);
  rate.write_ends(kStart, 50'000, 50'000);
  EXPECT_EQ(rate.bytes_per_second(), 1.25e6) << "a moment is too short";
  rate.write_begins(kStart + 100ms, 25'000);
  EXPECT_NEAR(rate.bytes_per_second(), 2.5e5, 1);
}

TEST(BandwidthEstimator, KeepsAMinimumRateOnAStalledLink) {
  BandwidthEstimator rate;
  rate.write_begins(kStart, 0);
  rate.write_ends(kStart, 50'000, 50'000);
  rate.write_begins(kStart + 10min, 50'000);
  EXPECT_EQ(rate.bytes_per_second(), 1000);
}

TEST(BandwidthEstimator, IgnoresIdleTime) {
  BandwidthEstimator rate;
  rate.write_begins(kStart, 0);
  rate.write_ends(kStart + 10ms, 1'000'000, 0);
  const double fast = rate.bytes_per_second();
  rate.write_begins(kStart + 1h, 0);
  rate.write_ends(kStart + 1h + 10ms, 1'000'000, 0);
  EXPECT_NEAR(rate.bytes_per_second(), fast, 1);
}

TEST(BandwidthEstimator, IgnoresImpossibleNumbers) {
  BandwidthEstimator rate;
  rate.write_begins(kStart, 1'000'000);
  rate.write_ends(kStart, 20'000, 1'000'000);
  EXPECT_EQ(rate.bytes_per_second(), 1.25e6);
}

}  // namespace
}  // namespace multitetra
