#include "server/core/simplification/detail/changed_triangles.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace multitetra::testing {
namespace {

using Marks = std::vector<std::uint8_t>;

// A triangle in the plane z = 4 and one above it; vertex 6 lies below the plane.
const LatticeMesh kApart = {
    .resolution = 0,
    .vertices = {{0, 0, 4}, {8, 0, 4}, {0, 8, 4}, {1, 1, 6}, {2, 1, 8}, {1, 2, 8}, {2, 2, 0}},
    .triangles = {{0, 1, 2}, {3, 4, 5}}};

CollapsingMesh mesh_of(const std::vector<TriangleIndices>& triangles) {
  return {triangles, static_cast<std::uint32_t>(kApart.vertices.size())};
}

TEST(ChangedTriangles, MarkTheCornersOfIntersectingTriangles) {
  ChangedTriangles changed(kApart, {});
  EXPECT_EQ(changed.intersecting_corners(mesh_of({{0, 1, 2}, {3, 4, 6}})),
            (Marks{1, 1, 1, 1, 1, 0, 1}));
}

TEST(ChangedTriangles, MarkNothingForDisjointTriangles) {
  ChangedTriangles changed(kApart, {});
  EXPECT_TRUE(changed.intersecting_corners(mesh_of({{0, 1, 2}, {5, 3, 4}})).empty());
}

TEST(ChangedTriangles, MarkTheCornersOfATriangleThatIntersectsAnObstacle) {
  const std::vector<LatticeTriangle> obstacles = {{{{0, 0, 2}, {8, 0, 2}, {0, 8, 2}}}};
  const LatticeMesh above = {
      .resolution = 0, .vertices = kApart.vertices, .triangles = {{3, 4, 5}}};
  ChangedTriangles changed(above, obstacles);
  EXPECT_EQ(changed.intersecting_corners(mesh_of({{3, 4, 6}})), (Marks{0, 0, 0, 1, 1, 0, 1}));
}

// The last call passes the same surface again, so nothing has changed.
TEST(ChangedTriangles, MarkChangesSinceTheLastCall) {
  ChangedTriangles changed(kApart, {});
  EXPECT_FALSE(changed.intersecting_corners(mesh_of({{0, 1, 2}, {3, 4, 6}})).empty());
  EXPECT_TRUE(changed.intersecting_corners(mesh_of({{0, 1, 2}, {3, 4, 5}})).empty());
  EXPECT_FALSE(changed.intersecting_corners(mesh_of({{0, 1, 2}, {3, 6, 5}})).empty());
  EXPECT_TRUE(changed.intersecting_corners(mesh_of({{0, 1, 2}, {3, 6, 5}})).empty());
}

}  // namespace
}  // namespace multitetra::testing
