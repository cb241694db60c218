#include "server/core/framework/dividing_point.hpp"

#include <gtest/gtest.h>

#include <set>

#include "server/core/framework/tetrahedron.hpp"
#include "tests/support/explicit_framework.hpp"
#include "tests/support/fields.hpp"

namespace multitetra {
namespace {

using testing::ExplicitFramework;

// Calls `visit(point)` for every dividing point of the grid.
template <typename Visit>
void for_every_point(const Grid& grid, const Visit& visit) {
  const std::int32_t n = grid.side();
  for (std::int32_t z = 0; z <= n; ++z) {
    for (std::int32_t y = 0; y <= n; ++y) {
      for (std::int32_t x = 0; x <= n; ++x) {
        if (x % n == 0 && y % n == 0 && z % n == 0) continue;  // A corner of the grid.
        visit(DividingPoint({x, y, z}));
      }
    }
  }
}

bool is_center(const DividingPoint& point, const Grid& grid) {
  return point.kind() == PointKind::kCube && 2 * point.spacing() == grid.side();
}

class DividingPoints : public ::testing::TestWithParam<int> {
 protected:
  const Grid grid_{GetParam()};
  const std::int32_t side_ = grid_.side() + 1;
  const Volume volume_ = testing::fields::noise({side_, side_, side_}, 1);
  const Field field_{volume_, std::nullopt, 0};
  const ExplicitFramework framework_{field_};
};
INSTANTIATE_TEST_SUITE_P(Grids, DividingPoints, ::testing::Values(1, 2, 3));

TEST_P(DividingPoints, CoverAllGridPointsButCornersAndCenter) {
  std::set<GridPoint> expected;
  for_every_point(grid_, [&](const DividingPoint& p) {
    if (!is_center(p, grid_)) expected.insert(p.at());
  });
  std::set<GridPoint> divided;
  for (const auto& [point, count] : framework_.chain_lengths()) divided.insert(point);
  EXPECT_EQ(divided, expected);
}

TEST_P(DividingPoints, DivideFourEightOrSixTetrahedraInTheInterior) {
  for (const auto& [at, count] : framework_.chain_lengths()) {
    const DividingPoint point(at);
    bool is_inside = true;
    for (const GridPoint x : point.ring()) is_inside = is_inside && grid_.contains(x);
    const std::size_t whole = point.kind() == PointKind::kFace   ? 4
                              : point.kind() == PointKind::kEdge ? 8
                                                                 : 6;
    if (is_inside) {
      EXPECT_EQ(count, whole);
    } else {
      EXPECT_LT(count, whole);
    }
  }
}

TEST_P(DividingPoints, HaveTheLinkOfTheTetrahedraTheyDivide) {
  for (const auto& [at, count] : framework_.chain_lengths()) {
    std::set<GridPoint> ring;
    for (const GridPoint x : DividingPoint(at).ring()) {
      if (grid_.contains(x)) ring.insert(x);
    }
    EXPECT_EQ(ring, framework_.link(at));
  }
}

TEST_P(DividingPoints, LieAtTheMidpointOfTheirSplitEdge) {
  for_every_point(grid_, [&](const DividingPoint& p) {
    if (is_center(p, grid_)) return;
    const auto [a, b] = p.split_edge();
    EXPECT_EQ(midpoint(a, b), p.at());
    EXPECT_TRUE(grid_.contains(a) && grid_.contains(b));
  });
}

TEST_P(DividingPoints, HaveTheChildrenOfTheBisectionTree) {
  for (const auto& [at, count] : framework_.chain_lengths()) {
    std::set<GridPoint> children;
    for (const GridPoint child : DividingPoint(at).children(grid_)) children.insert(child);
    EXPECT_EQ(children, framework_.children(at));
  }
}

TEST_P(DividingPoints, HaveConsistentChildrenAndParents) {
  std::set<std::pair<GridPoint, GridPoint>> down;
  std::set<std::pair<GridPoint, GridPoint>> up;
  for_every_point(grid_, [&](const DividingPoint& p) {
    for (const GridPoint child : p.children(grid_)) down.insert({p.at(), child});
    for (const GridPoint parent : p.parents(grid_)) up.insert({parent, p.at()});
  });
  EXPECT_EQ(down, up);
}

TEST_P(DividingPoints, DivideTetrahedraOfOneDepth) {
  for_every_point(grid_, [&](const DividingPoint& p) {
    for (const GridPoint child : p.children(grid_)) {
      EXPECT_EQ(DividingPoint(child).depth(grid_), p.depth(grid_) + 1);
    }
  });
  EXPECT_EQ(center(root_cube(grid_)).depth(grid_), -1);
}

TEST_P(DividingPoints, HaveRegionsThatContainThoseOfTheirChildrenAndTheirDiamond) {
  const auto contains = [](const Box& box, const Vec3& p) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (p[axis] < box.low[axis] || p[axis] > box.high[axis]) return false;
    }
    return true;
  };
  for_every_point(grid_, [&](const DividingPoint& p) {
    const Box box = region(p);
    for (const GridPoint x : p.ring()) {
      EXPECT_TRUE(contains(
          box, {static_cast<double>(x.x), static_cast<double>(x.y), static_cast<double>(x.z)}));
    }
    for (const GridPoint child : p.children(grid_)) {
      const Box inner = region(DividingPoint(child));
      EXPECT_TRUE(contains(box, inner.low) && contains(box, inner.high));
    }
  });
}

TEST(Bisection, FillsTheGridWithSixUnitTetrahedraACube) {
  const Grid grid(3);
  const UniformModel model(grid, 1000);
  std::size_t count = 0;
  visit_leaves(model, grid, root_cube(grid), [&](const Tetrahedron& t) {
    ++count;
    EXPECT_FALSE(t.is_divisible());
  });
  EXPECT_EQ(count, 6U * 8 * 8 * 8);
}

TEST(Bisection, DoublesTheNumberOfTetrahedraWithEveryLevel) {
  const Grid grid(3);
  for (int depth = 0; depth <= 8; ++depth) {
    std::size_t count = 0;
    visit_leaves(UniformModel(grid, depth), grid, root_cube(grid),
                 [&](const Tetrahedron&) { ++count; });
    EXPECT_EQ(count, std::size_t{12} << depth) << depth;
  }
}

}  // namespace
}  // namespace multitetra
