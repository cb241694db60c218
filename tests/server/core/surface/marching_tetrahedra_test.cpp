#include "server/core/surface/marching_tetrahedra.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>

#include "tests/support/distance.hpp"

namespace multitetra {
namespace {

using testing::operator-;

constexpr std::array<GridPoint, 4> kCorners = {GridPoint{0, 0, 0}, GridPoint{2, 2, 0},
                                               GridPoint{2, 0, 0}, GridPoint{1, 1, 1}};
constexpr int kResolution = 5;

Vec3 position(const LatticePoint& p) { return grid_coordinates(p, kResolution); }
Vec3 position(const GridPoint& p) {
  return {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
}

TEST(MarchingTetrahedron, FacesTheLowValuesInEverySignPatternAndCornerOrder) {
  std::array<std::size_t, 4> order = {0, 1, 2, 3};
  do {
    for (int pattern = 1; pattern < 15; ++pattern) {
      std::array<GridPoint, 4> corners{};
      std::array<float, 4> values{};
      for (std::size_t i = 0; i < 4; ++i) {
        corners[i] = kCorners[order[i]];
        values[i] = (pattern >> order[i] & 1) != 0 ? 3.0F : -1.0F;
      }
      const TetrahedronSurface surface = marching_tetrahedron(corners, values, 0, kResolution);
      ASSERT_EQ(surface.count, std::popcount(static_cast<unsigned>(pattern)) == 2 ? 2U : 1U);
      for (std::size_t t = 0; t < surface.count; ++t) {
        const auto& [p, q, r] = surface.triangles[t];
        const Vec3 normal = cross(position(q) - position(p), position(r) - position(p));
        for (std::size_t i = 0; i < 4; ++i) {
          const double side = dot(position(corners[i]) - position(p), normal);
          EXPECT_TRUE(values[i] > 0 ? side < 0 : side > 0) << pattern;
        }
      }
    }
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST(MarchingTetrahedron, HasTheSameTrianglesForEveryOrderOfItsCorners) {
  std::set<std::set<LatticePoint>> vertex_sets;
  std::array<std::size_t, 4> order = {0, 1, 2, 3};
  const std::array<float, 4> values_of = {0.9F, 0.7F, -0.2F, -0.4F};
  do {
    std::array<GridPoint, 4> corners{};
    std::array<float, 4> values{};
    for (std::size_t i = 0; i < 4; ++i) {
      corners[i] = kCorners[order[i]];
      values[i] = values_of[order[i]];
    }
    const TetrahedronSurface surface = marching_tetrahedron(corners, values, 0, kResolution);
    ASSERT_EQ(surface.count, 2U);
    // One triangle does not determine the diagonal: compare the edge that both share.
    std::set<LatticePoint> first(surface.triangles[0].begin(), surface.triangles[0].end());
    std::set<LatticePoint> shared;
    for (const LatticePoint& p : surface.triangles[1]) {
      if (first.count(p) != 0) shared.insert(p);
    }
    vertex_sets.insert(shared);
  } while (std::next_permutation(order.begin(), order.end()));
  EXPECT_EQ(vertex_sets.size(), 1U);
}

TEST(MarchingTetrahedron, HasNoTrianglesWithAVoidCorner) {
  const float none = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(marching_tetrahedron(kCorners, {1, -1, none, 1}, 0, kResolution).count, 0U);
  EXPECT_EQ(marching_tetrahedron(kCorners, {none, -1, 1, 1}, 0, kResolution).count, 0U);
}

TEST(MarchingTetrahedron, CountsAValueEqualToTheIsovalueAsNegative) {
  EXPECT_EQ(marching_tetrahedron(kCorners, {0, 0, 0, 0}, 0, kResolution).count, 0U);
  EXPECT_EQ(marching_tetrahedron(kCorners, {0, 0, 1, 0}, 0, kResolution).count, 1U);
}

TEST(LatticeVertex, LiesStrictlyBetweenTheEnds) {
  const GridPoint g{4, 8, 0};
  const GridPoint h{8, 4, 4};
  for (const double c : {1e-300, 1e-9, 0.5, 1 - 1e-9}) {
    for (const int resolution : {1, 3, 8}) {
      const LatticePoint p = lattice_vertex(g, 0, h, 1, c, resolution);
      const int s = 1 << resolution;
      EXPECT_GT(p.x, 4 * s);
      EXPECT_LT(p.x, 8 * s);
      EXPECT_EQ(p.x - 4 * s, 8 * s - p.y);
      EXPECT_EQ(p.x - 4 * s, p.z);
    }
  }
}

TEST(LatticeVertex, IsIndependentOfTheDirectionOfTheEdge) {
  const GridPoint g{0, 2, 0};
  const GridPoint h{2, 0, 0};
  for (int i = 1; i < 200; ++i) {
    const double c = i / 200.0;
    EXPECT_EQ(lattice_vertex(g, 0.0, h, 1.0, c, 4), lattice_vertex(h, 1.0, g, 0.0, c, 4));
  }
}

TEST(LatticeVertex, IsTheLatticePointNearestToTheCrossing) {
  EXPECT_EQ(lattice_vertex({0, 0, 0}, 0, {4, 0, 0}, 1, 0.25, 3), (LatticePoint{8, 0, 0}));
  EXPECT_EQ(lattice_vertex({0, 0, 0}, 0, {1, 1, 0}, 8, 3.4, 3), (LatticePoint{3, 3, 0}));
  EXPECT_EQ(lattice_vertex({0, 0, 0}, 0, {1, 1, 0}, 8, 3.6, 3), (LatticePoint{4, 4, 0}));
  EXPECT_EQ(lattice_vertex({0, 0, 0}, 500, {1, 0, 0}, 3000, 500.5, 5), (LatticePoint{1, 0, 0}))
      << "moved by almost a lattice step, since vertices are never at the ends";
}

}  // namespace
}  // namespace multitetra
