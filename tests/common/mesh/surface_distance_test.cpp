#include "common/mesh/surface_distance.hpp"

#include <cmath>
#include <limits>
#include <random>
#include <stop_token>
#include <vector>

#include <gtest/gtest.h>

#include "common/base/in_parallel.hpp"
#include "tests/support/distance.hpp"
#include "tests/support/distance_statistics.hpp"

namespace multitetra {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The unit square at height z, as two triangles.
std::vector<SurfaceTriangle> square(double z) {
  return {{Vec3{0, 0, z}, Vec3{1, 0, z}, Vec3{1, 1, z}},
          {Vec3{0, 0, z}, Vec3{1, 1, z}, Vec3{0, 1, z}}};
}

double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1.0p-53; }

Vec3 place(std::mt19937_64& random, double size) {
  return {size * uniform(random), size * uniform(random), size * uniform(random)};
}

// Small triangles, large ones across the whole volume, and degenerate ones.
std::vector<SurfaceTriangle> triangle_soup(std::mt19937_64& random, std::size_t count) {
  std::vector<SurfaceTriangle> soup;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 at = place(random, 10);
    const double size = i % 7 == 0 ? 10.0 : 0.3;
    SurfaceTriangle t = {at, at, at};
    if (i % 11 != 0) t[1] = testing::operator+(at, place(random, size));
    if (i % 13 != 0) t[2] = testing::operator+(at, place(random, size));
    if (i % 17 == 0) t[2] = testing::operator*(0.5, testing::operator+(t[0], t[1]));
    soup.push_back(t);
  }
  return soup;
}

double unlimited(const Vec3&) { return kInfinity; }

TEST(DistanceToTriangle, MeasuresToInteriorEdgesAndCorners) {
  const SurfaceTriangle t = {Vec3{0, 0, 0}, Vec3{4, 0, 0}, Vec3{0, 4, 0}};
  EXPECT_DOUBLE_EQ(distance_to_triangle({1, 1, 3}, t), 3);
  EXPECT_DOUBLE_EQ(distance_to_triangle({1, 1, -3}, t), 3);
  EXPECT_DOUBLE_EQ(distance_to_triangle({1, 1, 0}, t), 0);
  EXPECT_DOUBLE_EQ(distance_to_triangle({2, -3, 4}, t), 5);
  EXPECT_DOUBLE_EQ(distance_to_triangle({4, 4, 0}, t), std::sqrt(8));
  EXPECT_DOUBLE_EQ(distance_to_triangle({-3, -4, 12}, t), 13);
  EXPECT_DOUBLE_EQ(distance_to_triangle({7, -4, 0}, t), 5);
}

TEST(DistanceToTriangle, TreatsDegenerateTrianglesAsSegmentOrPoint) {
  const SurfaceTriangle segment = {Vec3{0, 0, 0}, Vec3{4, 0, 0}, Vec3{2, 0, 0}};
  EXPECT_DOUBLE_EQ(distance_to_triangle({3, 3, 4}, segment), 5);
  EXPECT_DOUBLE_EQ(distance_to_triangle({7, 4, 0}, segment), 5);
  const SurfaceTriangle point = {Vec3{1, 1, 1}, Vec3{1, 1, 1}, Vec3{1, 1, 1}};
  EXPECT_DOUBLE_EQ(distance_to_triangle({1, 4, 5}, point), 5);
}

TEST(NearestTriangle, FindsTheNearestOfAll) {
  std::mt19937_64 random(5);
  for (const std::size_t count : {1U, 2U, 4U, 5U, 9U, 33U, 700U}) {
    const auto soup = triangle_soup(random, count);
    const NearestTriangle surface(soup);
    for (int i = 0; i < 200; ++i) {
      const Vec3 p = testing::operator-(place(random, 20), Vec3{5, 5, 5});
      double nearest = kInfinity;
      for (const SurfaceTriangle& t : soup) nearest = std::min(nearest, distance_to_triangle(p, t));
      ASSERT_EQ(surface.distance(p), nearest) << count << " triangles";
    }
  }
}

// Compares with an independent formula: tests/support/distance.hpp.
TEST(NearestTriangle, AgreesWithAnotherFormula) {
  std::mt19937_64 random(6);
  for (int i = 0; i < 5000; ++i) {
    const SurfaceTriangle t = {place(random, 3), place(random, 3), place(random, 3)};
    const Vec3 p = place(random, 4);
    ASSERT_NEAR(distance_to_triangle(p, t), testing::distance_to_triangle(p, t), 1e-9);
  }
}

TEST(NearestTriangle, IsInfinitelyFarForAnEmptyMesh) {
  const NearestTriangle nothing({});
  EXPECT_TRUE(nothing.is_empty());
  EXPECT_EQ(nothing.distance({0, 0, 0}), kInfinity);
}

TEST(SampledPoints, LieOnTheSurface) {
  std::mt19937_64 random(7);
  const auto soup = triangle_soup(random, 300);
  const NearestTriangle surface(soup);
  const auto points = sampled_points(soup, 2000);
  EXPECT_EQ(points.size(), 2000U);
  for (const Vec3& p : points) ASSERT_LT(surface.distance(p), 1e-12);
}

TEST(SampledPoints, SpreadByArea) {
  const std::vector<SurfaceTriangle> surface = {
      {Vec3{0, 0, 0}, Vec3{2, 0, 0}, Vec3{0, 1, 0}},
      {Vec3{0, 0, 1}, Vec3{0, 0, 1}, Vec3{5, 5, 1}},  // Has no area.
      {Vec3{0, 0, 2}, Vec3{2, 0, 2}, Vec3{0, 3, 2}}};
  std::array<int, 3> count{};
  double low = 0;
  for (const Vec3& p : sampled_points(surface, 4000)) {
    ++count[static_cast<std::size_t>(p[2])];
    if (p[2] == 2 && p[0] + 2.0 / 3 * p[1] < 1) low += 1;
  }
  EXPECT_NEAR(count[0], 1000, 1);
  EXPECT_EQ(count[1], 0);
  EXPECT_NEAR(count[2], 3000, 1);
  EXPECT_NEAR(low / 3000, 0.25, 0.03) << "a quarter of the triangle lies below its middle line";
}

TEST(SampledPoints, AreDeterministicForASeed) {
  const auto surface = square(0);
  EXPECT_EQ(sampled_points(surface, 100, 3), sampled_points(surface, 100, 3));
  EXPECT_NE(sampled_points(surface, 100, 3), sampled_points(surface, 100, 4));
}

TEST(SampledPoints, AreNoneWithoutArea) {
  EXPECT_TRUE(sampled_points({}, 100).empty());
  const std::vector<SurfaceTriangle> point = {{Vec3{1, 1, 1}, Vec3{1, 1, 1}, Vec3{1, 1, 1}}};
  EXPECT_TRUE(sampled_points(point, 100).empty());
}

TEST(SurfaceDistances, MatchTheDistanceOfParallelSquares) {
  const auto points = sampled_points(square(0), 500);
  const auto d = distances(points, NearestTriangle(square(0.25)), unlimited);
  EXPECT_EQ(d.samples, 500U);
  EXPECT_DOUBLE_EQ(d.maximum, 0.25);
  EXPECT_DOUBLE_EQ(d.percentile_99, 0.25);
  EXPECT_DOUBLE_EQ(d.mean, 0.25);
  EXPECT_EQ(d.above_limit, 0U);
}

TEST(SurfaceDistances, DistinguishMaximumAndPercentile) {
  std::vector<Vec3> points(1000, Vec3{0.5, 0.5, 1});
  for (std::size_t i = 0; i < 10; ++i) points[100 * i] = {0.5, 0.5, 3};
  const auto d = distances(points, NearestTriangle(square(0)), unlimited);
  EXPECT_DOUBLE_EQ(d.maximum, 3);
  EXPECT_DOUBLE_EQ(d.percentile_99, 1);
  EXPECT_DOUBLE_EQ(d.mean, 1.02);
}

// A large distance may be within its place's limit, a small one above it.
TEST(SurfaceDistances, AreComparedWithTheLocalLimit) {
  const std::vector<Vec3> points = {{0.1, 0.5, 3}, {0.9, 0.5, 1}, {0.8, 0.5, 0.1}};
  const auto limit = [](const Vec3& p) { return p[0] < 0.5 ? 5.0 : 0.5; };
  const auto d = distances(points, NearestTriangle(square(0)), limit);
  EXPECT_DOUBLE_EQ(d.maximum, 3);
  EXPECT_EQ(d.above_limit, 1U);
  EXPECT_EQ(d.worst_place, points[1]);
  EXPECT_DOUBLE_EQ(d.worst_distance, 1);
  EXPECT_DOUBLE_EQ(d.worst_limit, 0.5);
}

TEST(SurfaceDistances, AreInfiniteOrZeroForEmptyMeshes) {
  const auto far = distances(sampled_points(square(0), 10), NearestTriangle({}),
                             [](const Vec3&) { return 1e300; });
  EXPECT_EQ(far.maximum, kInfinity);
  EXPECT_EQ(far.above_limit, 10U);
  const auto none = distances({}, NearestTriangle(square(0)), unlimited);
  EXPECT_EQ(none.samples, 0U);
  EXPECT_EQ(none.maximum, 0);
}

TEST(NearestTriangle, IsNotBuiltAfterAStop) {
  const std::vector<SurfaceTriangle> triangles(20'000);
  std::stop_source stop;
  EXPECT_NO_THROW(NearestTriangle(triangles, stop.get_token()));
  stop.request_stop();
  EXPECT_THROW(NearestTriangle(triangles, stop.get_token()), Cancelled);
}

}  // namespace
}  // namespace multitetra
