// Compares self-intersections of meshes with a brute-force check: segments against triangles, all
// pairs, in 128-bit arithmetic.
#include "tests/support/lattice_intersections.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <vector>

#include "common/mesh/lattice_plane.hpp"

namespace multitetra {
namespace {

__extension__ typedef __int128 Wide;

Wide volume(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c,
            const LatticePoint& d) {
  const Wide x[3] = {b.x - a.x, b.y - a.y, b.z - a.z};
  const Wide y[3] = {c.x - a.x, c.y - a.y, c.z - a.z};
  const Wide z[3] = {d.x - a.x, d.y - a.y, d.z - a.z};
  return x[0] * (y[1] * z[2] - y[2] * z[1]) + x[1] * (y[2] * z[0] - y[0] * z[2]) +
         x[2] * (y[0] * z[1] - y[1] * z[0]);
}

int sign(Wide v) { return v > 0 ? 1 : v < 0 ? -1 : 0; }

// Requires general position: no four corners of the triangles are coplanar, except shared ones.
bool pierces(const LatticePoint& p, const LatticePoint& q, const LatticeTriangle& t) {
  if (sign(volume(t[0], t[1], t[2], p)) == sign(volume(t[0], t[1], t[2], q))) return false;
  const int a = sign(volume(p, q, t[0], t[1]));
  return a == sign(volume(p, q, t[1], t[2])) && a == sign(volume(p, q, t[2], t[0]));
}
bool meet_in_general(const LatticeTriangle& a, const LatticeTriangle& b) {
  const std::set<LatticePoint> of_a(a.begin(), a.end());
  const std::set<LatticePoint> of_b(b.begin(), b.end());
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    if (!of_b.contains(a[i]) && !of_b.contains(a[j]) && pierces(a[i], a[j], b)) return true;
    if (!of_a.contains(b[i]) && !of_a.contains(b[j]) && pierces(b[i], b[j], a)) return true;
  }
  return false;
}

class RandomTriangles {
 public:
  explicit RandomTriangles(std::int32_t side) : coordinate_(0, side) {}
  LatticePoint point() {
    return {coordinate_(random_), coordinate_(random_), coordinate_(random_)};
  }
  // A random triangle that shares up to two corners with `other`.
  LatticeTriangle beside(const LatticeTriangle& other) {
    LatticeTriangle t = {point(), point(), point()};
    const std::size_t common = random_() % 3;
    const std::size_t first = random_() % 3;
    for (std::size_t i = 0; i < common; ++i) t[(first + i) % 3] = other[(2 * first + i) % 3];
    return t;
  }

 private:
  std::mt19937_64 random_{3};
  std::uniform_int_distribution<std::int32_t> coordinate_;
};

TEST(LatticePlane, DetectsPiercingEdgesWithAnyCommonCorners) {
  RandomTriangles random(1 << kMaxLatticeBits);
  int meeting = 0;
  for (int i = 0; i < 20'000; ++i) {
    const LatticeTriangle a = {random.point(), random.point(), random.point()};
    const LatticeTriangle b = random.beside(a);
    const bool expected = meet_in_general(a, b);
    meeting += expected ? 1 : 0;
    EXPECT_EQ(intersect(LatticePlane(a), LatticePlane(b)), expected);
    EXPECT_EQ(intersect(LatticePlane(b), LatticePlane(a)), expected);
    EXPECT_EQ(intersect(LatticePlane({a[1], a[0], a[2]}), LatticePlane({b[2], b[0], b[1]})),
              expected);
  }
  EXPECT_GT(meeting, 1000);
}

bool touch(const LatticeTriangle& a, const LatticeTriangle& b) {
  const bool found = intersect(LatticePlane(a), LatticePlane(b));
  EXPECT_EQ(intersect(LatticePlane(b), LatticePlane(a)), found);
  return found;
}

TEST(LatticePlane, CountsTouchingExceptAtCommonCornersAndEdges) {
  const LatticeTriangle floor = {{{0, 0, 0}, {8, 0, 0}, {0, 8, 0}}};
  EXPECT_TRUE(touch(floor, {{{2, 2, 0}, {2, 2, 5}, {3, 2, 5}}})) << "A corner on its inside.";
  EXPECT_TRUE(touch(floor, {{{4, 0, 0}, {4, -2, 5}, {3, -2, 5}}})) << "A corner on its edge.";
  EXPECT_TRUE(touch(floor, {{{8, 8, 0}, {0, 0, 0}, {8, 8, 5}}})) << "An edge through a corner.";
  EXPECT_TRUE(touch(floor, {{{1, 1, 0}, {2, 1, 0}, {1, 2, 0}}})) << "Inside, in its plane.";
  EXPECT_TRUE(touch(floor, {{{-9, -9, 0}, {30, -9, 0}, {-9, 30, 0}}})) << "Around it.";
  EXPECT_TRUE(touch(floor, {{{2, -1, 0}, {3, -1, 0}, {2, 9, 0}}})) << "Across, in its plane.";
  EXPECT_TRUE(touch(floor, {{{-1, 0, 0}, {9, 0, 0}, {4, -5, 3}}})) << "Along an edge.";
  EXPECT_FALSE(touch(floor, {{{2, 2, 1}, {5, 2, 1}, {2, 5, 1}}})) << "Above.";
  EXPECT_FALSE(touch(floor, {{{8, 8, 0}, {8, 8, 5}, {9, 8, 5}}})) << "Beyond its edge.";
  EXPECT_FALSE(touch(floor, {{{5, 5, 0}, {9, 5, 0}, {5, 9, 0}}})) << "In its plane, beyond.";
  EXPECT_FALSE(touch(floor, {{{8, 0, 0}, {9, 0, 5}, {8, 1, 5}}})) << "A common corner.";
  EXPECT_FALSE(touch(floor, {{{8, 0, 0}, {12, 0, 0}, {12, 3, 0}}})) << "That, in the plane.";
  EXPECT_TRUE(touch(floor, {{{8, 0, 0}, {2, 1, 0}, {2, 2, 4}}})) << "An edge from it lies inside.";
  EXPECT_TRUE(touch(floor, {{{8, 0, 0}, {4, 0, 0}, {2, -2, 4}}})) << "One lies on an edge.";
  EXPECT_TRUE(touch(floor, {{{8, 0, 0}, {1, 1, 3}, {1, 1, -3}}})) << "It comes back through it.";
  EXPECT_FALSE(touch(floor, {{{8, 0, 0}, {0, 0, 0}, {3, 3, 4}}})) << "A common edge.";
  EXPECT_FALSE(touch(floor, {{{8, 0, 0}, {0, 0, 0}, {3, -3, 0}}})) << "That, side by side.";
  EXPECT_TRUE(touch(floor, {{{8, 0, 0}, {0, 0, 0}, {1, 1, 0}}})) << "That, on each other.";
  EXPECT_TRUE(touch(floor, {{{8, 0, 0}, {0, 0, 0}, {0, 8, 0}}})) << "The same, turned over.";
}

TEST(LatticeIntersections, MatchAllPairs) {
  for (const std::int32_t size : {40, 400, 4000}) {
    RandomTriangles corner(1 << 14);
    RandomTriangles extent(size);
    std::vector<LatticeTriangle> triangles;
    for (int i = 0; i < 400; ++i) {
      const LatticePoint at = corner.point();
      LatticeTriangle& t = triangles.emplace_back();
      for (LatticePoint& p : t) {
        const LatticePoint by = extent.point();
        // Few large triangles among many small ones.
        const std::int32_t factor = i % 50 == 0 ? 3 : 1;
        p = {at.x / 8 + factor * by.x, at.y / 8 + factor * by.y, at.z / 8 + factor * by.z};
      }
    }
    std::set<std::size_t> in_pairs;
    LatticeIntersections expected;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        if (!meet_in_general(triangles[i], triangles[j])) continue;
        ++expected.pairs;
        in_pairs.insert({i, j});
      }
    }
    expected.triangles = in_pairs.size();
    EXPECT_EQ(lattice_intersections(index_triangles(triangles, kDefaultLatticeResolution)),
              expected);
    if (size > 100) {
      EXPECT_GT(expected.pairs, 10U);
    }
  }
}

TEST(LatticeIntersections, AreNoneForAnEmptyMesh) {
  EXPECT_EQ(lattice_intersections({}), LatticeIntersections());
}

}  // namespace
}  // namespace multitetra
