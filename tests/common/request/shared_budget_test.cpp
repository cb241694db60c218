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

TEST(SharedBudget, IsUnlimitedWithoutABudget) {
  EXPECT_EQ(shares_of(0, std::vector<std::uint64_t>{5, 6}), (std::vector<std::uint64_t>{0, 0}));
}

TEST(SharedBudget, IsSharedOnlyBySeveralRequestsWithABudget) {
  const IsosurfaceRequest request{.max_triangles = 1002, .max_bytes = 0};
  std::vector<IsosurfaceRequest> requests = {request};
  EXPECT_FALSE(needs_shared_budget(requests));
  requests.push_back(request);
  ASSERT_TRUE(needs_shared_budget(requests));
  EXPECT_TRUE(check_shared_budget(requests));
  share_budget(requests, std::vector<EstimatedSize>{{.triangles = 100}, {.triangles = 300}});
  EXPECT_EQ(requests[0].max_triangles, 251U);
  EXPECT_EQ(requests[1].max_triangles, 751U);
  EXPECT_EQ(requests[0].max_bytes, 0U);
  requests.assign(2, {.max_triangles = 9, .max_bytes = 1});
  EXPECT_EQ(check_shared_budget(requests).error().code, ErrorCode::kInvalidArgument);
  requests.assign(2, {});
  EXPECT_FALSE(needs_shared_budget(requests));
}

}  // namespace
}  // namespace multitetra
