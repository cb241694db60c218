#include "common/request/shared_budget.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <random>

namespace multitetra {
namespace {

TEST(SharedBudget, IsSharedInProportionAndNeverExceeded) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 300; ++i) {
    std::vector<std::uint64_t> sizes(1 + random() % 16);
    for (std::uint64_t& size : sizes) size = random() % 1'000'000;
    const std::uint64_t budget = sizes.size() + random() % 5'000'000;
    const std::vector<std::uint64_t> shares = shares_of(budget, sizes);
    ASSERT_EQ(shares.size(), sizes.size());
    EXPECT_LE(std::accumulate(shares.begin(), shares.end(), std::uint64_t{0}), budget);
    for (const std::uint64_t share : shares) EXPECT_GE(share, 1U);
  }
  EXPECT_EQ(shares_of(1002, std::vector<std::uint64_t>{100, 300}),
            (std::vector<std::uint64_t>{251, 751}));
}

TEST(SharedBudget, OfNothingIsNoLimitForAnybody) {
  EXPECT_EQ(shares_of(0, std::vector<std::uint64_t>{5, 6}), (std::vector<std::uint64_t>{0, 0}));
}

}  // namespace
}  // namespace multitetra
