#include "common/mesh/self_intersections.hpp"

#include <array>
#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>
#include <boost/multiprecision/cpp_int.hpp>

#include "common/mesh/detail/exact_predicates.hpp"
#include "common/mesh/detail/triangle_intersection.hpp"
#include "tests/support/triangle_meshes.hpp"

namespace multitetra {
namespace {

using testing::box;
using testing::joined;

std::uint64_t intersecting(const TriangleMesh& mesh) {
  return self_intersections(welded(mesh).mesh).triangles;
}

// ---- orientation

int rational_orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  using Rational = boost::multiprecision::cpp_rational;
  std::array<std::array<Rational, 3>, 3> m;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    m[0][axis] = Rational(a[axis]) - Rational(d[axis]);
    m[1][axis] = Rational(b[axis]) - Rational(d[axis]);
    m[2][axis] = Rational(c[axis]) - Rational(d[axis]);
  }
  const Rational value = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                         m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
  return value.sign();
}

// Nearly coplanar points of different magnitudes.
TEST(Orientation, IsExact) {
  std::mt19937_64 random(3);
  std::uniform_int_distribution<int> small(-3, 3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int zeros = 0;
  for (int i = 0; i < 20'000; ++i) {
    const double scale = std::ldexp(1.0, i % 7 == 0 ? -600 : i % 5 == 0 ? 300 : 0);
    const auto place = [&]() -> Vec3 {
      return {scale * small(random), scale * small(random), scale * (3 + 0.1 * small(random))};
    };
    std::array<Vec3, 4> p = {place(), place(), place(), place()};
    if (i % 3 == 0) {  // A point that rounding moved off the plane of the others.
      const double u = uniform(random);
      const double v = uniform(random);
      p[3] = moved(moved(p[0], u, difference(p[1], p[0])), v, difference(p[2], p[0]));
    }
    if (i % 11 == 0) p[2][1] += 1e-30;  // Far below the last bit of the others.
    const int expected = rational_orientation(p[0], p[1], p[2], p[3]);
    ASSERT_EQ(orientation(p[0], p[1], p[2], p[3]), expected) << i;
    zeros += expected == 0;
  }
  EXPECT_GT(zeros, 1000);
}

TEST(Orientation, IsCounterClockwiseForTrianglesOfAPlane) {
  EXPECT_EQ(orientation(Vec2{0, 0}, Vec2{1, 0}, Vec2{0, 1}), 1);
  EXPECT_EQ(orientation(Vec2{0, 0}, Vec2{0, 1}, Vec2{1, 0}), -1);
  EXPECT_EQ(orientation(Vec2{0.1, 0.1}, Vec2{0.2, 0.2}, Vec2{0.3, 0.3}),
            0.1 + 0.2 == 0.3 ? 0 : orientation(Vec2{0.1, 0.1}, Vec2{0.2, 0.2}, Vec2{0.3, 0.3}));
  EXPECT_EQ(orientation(Vec2{0, 0}, Vec2{1e-300, 1e-300}, Vec2{3e-300, 3e-300}), 0);
  EXPECT_EQ(orientation(Vec2{0, 0}, Vec2{1e-300, 1e-300}, Vec2{1e-300, 2e-300}), 1);
}

// ---- neighbours

TEST(SelfIntersections, AreNoneInABowtie) {
  EXPECT_EQ(intersecting({.vertices = {{0, 0, 0}, {-1, -1, 0}, {-1, 1, 0}, {1, -1, 0}, {1, 1, 0}},
                          .triangles = {{0, 1, 2}, {0, 3, 4}}}),
            0U);
}

TEST(SelfIntersections, CountTrianglesThatMeetBeyondACommonVertex) {
  const auto with = [](const Vec3& a, const Vec3& b) {
    return intersecting({.vertices = {{0, 0, 0}, {4, -2, 0}, {4, 2, 0}, a, b},
                         .triangles = {{0, 1, 2}, {0, 3, 4}}});
  };
  EXPECT_EQ(with({4, 0, -2}, {4, 0, 2}), 2U) << "through it";
  EXPECT_EQ(with({2, 0, -2}, {2, 0, 2}), 2U) << "through its inside";
  EXPECT_EQ(with({1, 0, 0}, {1, 0, 2}), 2U) << "a side lies in it";
  EXPECT_EQ(with({1, 0, 0}, {1, 1, 0}), 2U) << "in its plane";
  EXPECT_EQ(with({-1, 0, 0}, {-1, 1, 0}), 0U) << "in its plane, behind";
  EXPECT_EQ(with({4, 0, 1}, {4, 0, 2}), 0U) << "above";
  EXPECT_EQ(with({8, -4, 0}, {0, 0, 3}), 2U) << "along a side";
}

TEST(SelfIntersections, CountTrianglesWithACommonEdgeIfTheyOverlap) {
  const auto with = [](const Vec3& d) {
    return intersecting(
        {.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, d}, .triangles = {{0, 1, 2}, {1, 0, 3}}});
  };
  EXPECT_EQ(with({0, -1, 0}), 0U);
  EXPECT_EQ(with({0, 1, 1e-300}), 0U) << "folded, but not flat";
  EXPECT_EQ(with({3, 5, 0}), 2U);
}

TEST(SelfIntersections, CountADuplicateTriangleTwice) {
  const TriangleMesh once = {.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
                             .triangles = {{0, 1, 2}}};
  EXPECT_EQ(intersecting(joined(once, once)), 2U);
}

// ---- others

TEST(SelfIntersections, CountTouchingTriangles) {
  const auto with = [](const std::array<Vec3, 3>& other) {
    return intersecting(
        {.vertices = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, other[0], other[1], other[2]},
         .triangles = {{0, 1, 2}, {3, 4, 5}}});
  };
  EXPECT_EQ(with({Vec3{1, 1, 0}, {1, 1, 1}, {2, 1, 1}}), 2U) << "a corner on its inside";
  EXPECT_EQ(with({Vec3{2, 0, 0}, {2, -1, 0}, {3, -1, 0}}), 2U) << "a corner on its side";
  EXPECT_EQ(with({Vec3{1, 1, 0}, {2, 1, 0}, {1, 2, 0}}), 2U) << "inside it";
  EXPECT_EQ(with({Vec3{-9, -9, 0}, {99, -9, 0}, {-9, 99, 0}}), 2U) << "around it";
  EXPECT_EQ(with({Vec3{3, 3, 0}, {4, 3, 0}, {3, 4, 0}}), 0U) << "beside it in its plane";
  EXPECT_EQ(with({Vec3{1, 1, 1e-9}, {1, 1, 1}, {2, 1, 1}}), 0U) << "just above";
}

TEST(SelfIntersections, CountTouchingCubesByWhatTheyShare) {
  const TriangleMesh cube = box({0, 0, 0}, {1, 1, 1});
  EXPECT_EQ(intersecting(cube), 0U);
  EXPECT_EQ(intersecting(joined(cube, box({1, 1, 1}, {2, 2, 2}))), 0U) << "a vertex";
  EXPECT_EQ(intersecting(joined(cube, box({1, 1, 0}, {2, 2, 1}))), 0U) << "an edge";
  EXPECT_GE(intersecting(joined(cube, box({1, 0, 0}, {2, 1, 1}))), 4U) << "a face, twice there";
  EXPECT_GE(intersecting(joined(cube, box({0.25, 0.25, 1}, {0.75, 0.75, 2}))), 3U) << "a part";
  EXPECT_EQ(intersecting(joined(cube, box({1.5, 0, 0}, {2, 1, 1}))), 0U) << "nothing";
  // Three edges of either cube each cross a face of the other, at midpoints of edges and faces.
  EXPECT_GT(intersecting(joined(cube, box({0.5, 0.5, 0.5}, {1.5, 1.5, 1.5}))), 6U);
}

TEST(SelfIntersections, OmitTrianglesWithoutArea) {
  const SelfIntersections found =
      self_intersections({.vertices = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}},
                          .triangles = {{0, 1, 2}, {0, 2, 3}}});
  EXPECT_EQ(found.flat_triangles, 1U);
  EXPECT_EQ(found.triangles, 0U);
}

TEST(SelfIntersections, MatchAllPairs) {
  const TriangleMesh spheres =
      welded(joined(testing::sphere({0, 0, 0}, 1, 12), testing::sphere({0.7, 0.3, 0.1}, 0.9, 9)))
          .mesh;
  const auto triangle = [&](std::size_t i) {
    const TriangleIndices& t = spheres.triangles[i];
    return MeshTriangle{t,
                        {spheres.vertices[t[0]], spheres.vertices[t[1]], spheres.vertices[t[2]]}};
  };
  std::uint64_t pairs = 0;
  std::vector<char> hit(spheres.triangles.size(), 0);
  for (std::size_t i = 0; i < spheres.triangles.size(); ++i) {
    for (std::size_t j = i + 1; j < spheres.triangles.size(); ++j) {
      if (!intersect(triangle(i), triangle(j))) continue;
      ++pairs;
      hit[i] = hit[j] = 1;
    }
  }
  for (const std::size_t threads : {1U, 2U}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const SelfIntersections found = self_intersections(spheres);
    EXPECT_EQ(found.pairs, pairs);
    EXPECT_EQ(found.triangles, static_cast<std::uint64_t>(std::count(hit.begin(), hit.end(), 1)));
    EXPECT_GT(found.triangles, 20U);
    EXPECT_NEAR(length(found.place), 1, 0.1) << "on the first sphere";
  }
}

}  // namespace
}  // namespace multitetra
