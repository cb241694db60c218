#include "common/mesh/lattice.hpp"

#include <vector>

#include <gtest/gtest.h>

#include "common/mesh/octree_cube.hpp"

namespace multitetra {
namespace {

TEST(LatticePoint, OrdersKeysByZThenYThenX) {
  const std::int32_t end = std::int32_t{1} << kMaxLatticeBits;
  std::vector<LatticePoint> points;
  for (const std::int32_t z : {0, 1, end}) {
    for (const std::int32_t y : {0, 1, end}) {
      for (const std::int32_t x : {0, 1, end}) points.push_back({x, y, z});
    }
  }
  for (std::size_t i = 1; i < points.size(); ++i) {
    EXPECT_LT(points[i - 1].key(), points[i].key());
  }
}

TEST(LatticePoint, IsValidUpToTheFarEnd) {
  const std::int32_t end = std::int32_t{1} << kMaxLatticeBits;
  EXPECT_TRUE(is_on_lattice({0, 0, 0}));
  EXPECT_TRUE(is_on_lattice({end, end, end}));
  EXPECT_FALSE(is_on_lattice({end + 1, 0, 0}));
  EXPECT_FALSE(is_on_lattice({0, end + 1, 0}));
  EXPECT_FALSE(is_on_lattice({0, 0, end + 1}));
  EXPECT_FALSE(is_on_lattice({-1, 0, 0}));
  EXPECT_FALSE(is_on_lattice({0, -1, 0}));
  EXPECT_FALSE(is_on_lattice({0, 0, -1}));
}

TEST(LatticePoint, HasExactGridCoordinates) {
  EXPECT_EQ(grid_coordinates({33, 1, 1 << 20}, 5), (Vec3{33.0 / 32, 1.0 / 32, 32768}));
}

TEST(OctreeCube, FillsItselfWithEightChildren) {
  const OctreeCube cube{.exponent = 3, .x = 5, .y = 2, .z = 7};
  std::int64_t volume = 0;
  for (int index = 0; index < 8; ++index) {
    const OctreeCube child = cube.child(index);
    EXPECT_EQ(child.parent(), cube);
    volume += std::int64_t{child.side()} * child.side() * child.side();
    for (int other = 0; other < index; ++other) EXPECT_NE(child, cube.child(other));
  }
  EXPECT_EQ(volume, std::int64_t{cube.side()} * cube.side() * cube.side());
  EXPECT_EQ(cube.child(5), (OctreeCube{2, 11, 4, 15})) << "bits: x, y, z";
}

TEST(OctreeCube, ContainsOnlyItsClosedExtent) {
  const OctreeCube cube{.exponent = 2, .x = 1, .y = 0, .z = 3};
  const std::int32_t side = 4 << 5;
  const LatticePoint low = {side, 0, 3 * side};
  const LatticePoint high = {2 * side, side, 4 * side};
  EXPECT_TRUE(cube.contains(low, 5));
  EXPECT_TRUE(cube.contains(high, 5));
  EXPECT_FALSE(cube.contains({low.x - 1, low.y, low.z}, 5));
  EXPECT_FALSE(cube.contains({low.x, low.y - 1, low.z}, 5));
  EXPECT_FALSE(cube.contains({low.x, low.y, low.z - 1}, 5));
  EXPECT_FALSE(cube.contains({high.x + 1, high.y, high.z}, 5));
  EXPECT_FALSE(cube.contains({high.x, high.y + 1, high.z}, 5));
  EXPECT_FALSE(cube.contains({high.x, high.y, high.z + 1}, 5));
  EXPECT_FALSE(cube.contains(low, 4)) << "the same integers are elsewhere at another resolution";
}

TEST(OctreeCube, DoesNotOverflowAtTheLargestSize) {
  const OctreeCube cube{.exponent = kMaxLatticeBits, .x = 0, .y = 0, .z = 0};
  EXPECT_TRUE(cube.contains({1 << 20, 1 << 20, 1 << 20}, kMaxLatticeResolution));
}

TEST(OctreeCube, HasAReadableName) { EXPECT_EQ(to_string(OctreeCube{5, 3, 0, 7}), "cube 5:3/0/7"); }

}  // namespace
}  // namespace multitetra
