#include "server/certify/two_sided_distance.hpp"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include "common/base/in_parallel.hpp"
#include "common/mesh/surface_distance.hpp"
#include "tests/support/triangle_meshes.hpp"

namespace multitetra {
namespace {

TriangleMesh square(double z, double side = 1) {
  return {.vertices = {{0, 0, z}, {side, 0, z}, {side, side, z}, {0, side, z}},
          .triangles = {{0, 1, 2}, {0, 2, 3}}};
}

// The largest distance of a dense regular grid of points on every triangle.
double brute_force(const TriangleMesh& from, const TriangleMesh& to) {
  constexpr int kSteps = 40;
  double largest = 0;
  for (const TriangleIndices& t : from.triangles) {
    for (int i = 0; i <= kSteps; ++i) {
      for (int j = 0; i + j <= kSteps; ++j) {
        const double u = static_cast<double>(i) / kSteps;
        const double v = static_cast<double>(j) / kSteps;
        const Vec3 p =
            sum(sum(scaled(from.vertices[t[0]], 1 - u - v), scaled(from.vertices[t[1]], u)),
                scaled(from.vertices[t[2]], v));
        double nearest = std::numeric_limits<double>::infinity();
        for (const TriangleIndices& o : to.triangles) {
          nearest = std::min(nearest, distance_to_triangle(p, {to.vertices[o[0]], to.vertices[o[1]],
                                                               to.vertices[o[2]]}));
        }
        largest = std::max(largest, nearest);
      }
    }
  }
  return largest;
}

TEST(TwoSidedDistance, MatchesTheDistanceOfParallelSquares) {
  const auto [there, back] = two_sided_distance(square(0), square(0.25), {.samples = 500});
  for (const SurfaceDistance& way : {there, back}) {
    EXPECT_DOUBLE_EQ(way.maximum, 0.25);
    EXPECT_NEAR(way.maximum_at_most, 0.25, 1e-12);
    EXPECT_DOUBLE_EQ(way.mean, 0.25);
    EXPECT_DOUBLE_EQ(way.percentile_99, 0.25);
    EXPECT_EQ(way.samples, 500U);
  }
}

TEST(TwoSidedDistance, FindsAFarthestPointBetweenVertices) {
  // Four tiny triangles at the corners of the square, whose middle is farthest from them.
  TriangleMesh rim;
  for (int side = 0; side < 4; ++side) {
    const Vec3 at = {side % 2 == 0 ? 0.0 : 10.0, side / 2 == 0 ? 0.0 : 10.0, 0};
    rim = testing::joined(rim, {.vertices = {at, sum(at, {1e-6, 0, 0}), sum(at, {0, 1e-6, 0})},
                                .triangles = {{0, 1, 2}}});
  }
  const auto [there, back] =
      two_sided_distance(square(0, 10), rim, {.samples = 50, .tolerance = 1e-3});
  EXPECT_NEAR(there.maximum, std::sqrt(50), 2e-3);
  EXPECT_GE(there.maximum_at_most, std::sqrt(50) - 1e-5);
  EXPECT_LE(there.maximum_at_most, there.maximum + 1.1e-3);
  EXPECT_NEAR(there.farthest[0], 5, 0.01);
  EXPECT_NEAR(there.farthest[1], 5, 0.01);
  EXPECT_LT(back.maximum_at_most, 1e-5);
}

TEST(TwoSidedDistance, BoundsEveryPointOfRandomTriangles) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  const auto soup = [&](int count) {
    TriangleMesh mesh;
    for (int i = 0; i < count; ++i) {
      const Vec3 at = {3 * uniform(random), 3 * uniform(random), 3 * uniform(random)};
      const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
      for (int corner = 0; corner < 3; ++corner) {
        mesh.vertices.push_back(sum(at, {uniform(random), uniform(random), uniform(random)}));
      }
      mesh.triangles.push_back({first, first + 1, first + 2});
    }
    return mesh;
  };
  for (int round = 0; round < 5; ++round) {
    const TriangleMesh a = soup(12);
    const TriangleMesh b = soup(9);
    const auto [there, back] = two_sided_distance(a, b, {.samples = 1000, .tolerance = 0.002});
    const double dense_there = brute_force(a, b);
    const double dense_back = brute_force(b, a);
    EXPECT_LE(dense_there, there.maximum_at_most);
    EXPECT_GE(dense_there, there.maximum - 0.03);
    EXPECT_LE(there.maximum_at_most, there.maximum + 0.0021);
    EXPECT_LE(dense_back, back.maximum_at_most);
    EXPECT_LE(back.maximum_at_most, back.maximum + 0.0021);
    EXPECT_LE(there.mean, there.percentile_99);
    EXPECT_LE(there.percentile_99, there.maximum_at_most);
  }
}

// When pieces are dropped to save memory, the upper bound still includes them.
TEST(TwoSidedDistance, IsABoundWithoutMemoryForItsSearch) {
  const TriangleMesh a = testing::sphere({0, 0, 0}, 1, 10);
  const TriangleMesh b = testing::shifted(testing::sphere({0, 0, 0}, 1, 7), {0.1, 0, 0});
  const auto exact = two_sided_distance(a, b, {.tolerance = 1e-4}).mesh_to_reference;
  const auto hasty =
      two_sided_distance(a, b, {.tolerance = 1e-4, .max_pieces = 2}).mesh_to_reference;
  EXPECT_GT(hasty.undecided, 0U);
  EXPECT_EQ(exact.undecided, 0U);
  EXPECT_LE(hasty.maximum, exact.maximum_at_most);
  EXPECT_GE(hasty.maximum_at_most, exact.maximum);
  EXPECT_GT(hasty.maximum_at_most - hasty.maximum, exact.maximum_at_most - exact.maximum);
}

TEST(TwoSidedDistance, DecidesMoreTrianglesThanItSplitsAtOnce) {
  const TriangleMesh a = testing::sphere({0, 0, 0}, 1, 40);
  const TriangleMesh b = testing::shifted(testing::sphere({0, 0, 0}, 1, 23), {0.01, 0, 0});
  const auto found =
      two_sided_distance(a, b, {.tolerance = 1e-4, .max_pieces = 300}).mesh_to_reference;
  EXPECT_EQ(found.undecided, 0U);
  EXPECT_LE(found.maximum_at_most - found.maximum, 1e-4);
}

TEST(TwoSidedDistance, DecidesTheLimitBeforeTheMaximum) {
  const TriangleMesh a = testing::sphere({0, 0, 0}, 1, 40);
  const TriangleMesh b = testing::shifted(testing::sphere({0, 0, 0}, 1, 23), {0.01, 0, 0});
  const double maximum = two_sided_distance(a, b, {.tolerance = 1e-4}).mesh_to_reference.maximum;
  DistanceSearch search{.tolerance = 1e-4, .max_pieces = 150};
  EXPECT_GT(two_sided_distance(a, b, search).mesh_to_reference.maximum_at_most, 1.2 * maximum);
  search.limit = 1.2 * maximum;
  EXPECT_LE(two_sided_distance(a, b, search).mesh_to_reference.maximum_at_most, *search.limit);
}

// At a shared vertex any triangle of the fan may be found nearest.
TEST(TwoSidedDistance, DecidesNearlyEqualMeshesWithoutASearch) {
  const TriangleMesh a = testing::sphere({0, 0, 0}, 1, 20);
  const TriangleMesh b = testing::shifted(a, {1e-6, 0, 0});
  const auto [there, back] = two_sided_distance(a, b, {.tolerance = 1e-3, .max_pieces = 0});
  for (const SurfaceDistance& way : {there, back}) {
    EXPECT_EQ(way.undecided, 0U);
    EXPECT_LE(way.maximum_at_most, 1e-3);
  }
}

TEST(TwoSidedDistance, IsInfiniteForAnEmptyMesh) {
  const auto [there, back] = two_sided_distance({}, square(0), {});
  EXPECT_EQ(there.maximum_at_most, 0);
  EXPECT_TRUE(std::isinf(back.maximum));
  EXPECT_TRUE(std::isinf(back.maximum_at_most));
}

TEST(TwoSidedDistance, IsIndependentOfThreadCount) {
  const TriangleMesh a = testing::sphere({0, 0, 0}, 1, 20);
  const TriangleMesh b = testing::sphere({0.05, 0.02, 0}, 1.1, 17);
  const auto run = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return two_sided_distance(a, b, {.tolerance = 1e-3});
  };
  const auto one = run(1);
  const auto two = run(2);
  for (const auto way :
       {&TwoSidedDistance::mesh_to_reference, &TwoSidedDistance::reference_to_mesh}) {
    EXPECT_EQ((one.*way).maximum, (two.*way).maximum);
    EXPECT_EQ((one.*way).maximum_at_most, (two.*way).maximum_at_most);
    EXPECT_EQ((one.*way).mean, (two.*way).mean);
    EXPECT_EQ((one.*way).farthest, (two.*way).farthest);
  }
}

TEST(TwoSidedDistance, EndsWhenItIsStopped) {
  std::stop_source stop;
  stop.request_stop();
  EXPECT_THROW((void)two_sided_distance(square(0), square(1), {.stop = stop.get_token()}),
               Cancelled);
}

}  // namespace
}  // namespace multitetra
