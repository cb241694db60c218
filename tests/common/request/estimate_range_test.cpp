#include "common/request/estimate_range.hpp"

#include <gtest/gtest.h>

namespace multitetra {
namespace {

TEST(EstimateRange, IsRoundedOutwardToTwoDigits) {
  const TriangleRange range = expected_triangles(15'200, 0);
  EXPECT_EQ(range.least, 11'000u);  // 11 400, rounded down.
  EXPECT_EQ(range.most, 23'000u);   // 22 800, rounded up.
  EXPECT_EQ(expected_triangles(8, 0).least, 6u);
  EXPECT_EQ(expected_triangles(8, 0).most, 12u);
}

TEST(EstimateRange, IsEmptyForNoTriangles) {
  EXPECT_EQ(expected_triangles(0, 0).least, 0u);
  EXPECT_EQ(expected_triangles(0, 0).most, 0u);
}

TEST(EstimateRange, EndsAtTheBudget) {
  const TriangleRange range = expected_triangles(15'000, 12'345);
  EXPECT_EQ(range.least, 11'000u);
  EXPECT_EQ(range.most, 12'345u);
  EXPECT_EQ(expected_triangles(15'000, 1'000).least, 1'000u);
}

}  // namespace
}  // namespace multitetra
