#include "common/wire/scalar_codes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace multitetra {
namespace {

std::vector<LatticePoint> some_points(std::size_t count) {
  std::mt19937 random(4);
  std::vector<LatticePoint> points;
  for (std::size_t i = 0; i < count; ++i) {
    const auto coordinate = [&] { return static_cast<std::int32_t>(random() % 1000000); };
    const std::int32_t x = coordinate();
    const std::int32_t y = coordinate();
    points.push_back({x, y, coordinate()});
  }
  return points;
}

TEST(ScalarCodes, AreWithinHalfAStepInAnyVertexOrder) {
  const std::vector<LatticePoint> points = some_points(500);
  std::vector<double> values;
  for (const LatticePoint& p : points) values.push_back(std::sin(p.x) * 7);
  values[17] = std::nan("");
  for (const int bits : {8, 16}) {
    const ScalarRange range{.low = -7, .high = 7, .bits = bits};
    const std::string codes = encode_scalars(points, values, range);
    EXPECT_EQ(codes.size(), points.size() * static_cast<std::size_t>(bits / 8));
    std::vector<LatticePoint> reversed(points.rbegin(), points.rend());
    const auto decoded = decode_scalars(codes, reversed, range);
    ASSERT_TRUE(decoded);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto found = static_cast<double>((*decoded)[points.size() - 1 - i]);
      if (i == 17) {
        EXPECT_TRUE(std::isnan(found));
      } else {
        EXPECT_NEAR(found, values[i], 0.5001 * range.step());
      }
    }
  }
}

TEST(ScalarCodes, ClampToTheRange) {
  const std::vector<LatticePoint> points = {{1, 2, 3}, {2, 2, 3}};
  const ScalarRange range{.low = 0, .high = 10, .bits = 8};
  EXPECT_EQ(
      *decode_scalars(encode_scalars(points, std::vector<double>{-5, 1e300}, range), points, range),
      (std::vector<float>{0, 10}));
  const ScalarRange one{.low = 3, .high = 3, .bits = 16};
  EXPECT_EQ(*decode_scalars(encode_scalars(points, std::vector<double>{3, 3}, one), points, one),
            (std::vector<float>{3, 3}));
}

TEST(ScalarCodes, RejectCountsThatDifferFromTheVertices) {
  const std::vector<LatticePoint> points = some_points(3);
  const ScalarRange range{.low = 0, .high = 1};
  EXPECT_FALSE(decode_scalars("12345", points, range));
  EXPECT_TRUE(decode_scalars("123456", points, range));
}

}  // namespace
}  // namespace multitetra
