// Compares the bounding-box tree of triangles with a linear search.
#include "common/mesh/triangle_tree.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <random>
#include <set>
#include <utility>
#include <vector>

namespace multitetra {
namespace {

class RandomBoxes {
 public:
  TriangleBox box() {
    const std::int32_t side = std::int32_t{1} << random_() % 12;
    std::uniform_int_distribution<std::int32_t> corner(0, (1 << 13) - side);
    std::uniform_int_distribution<std::int32_t> extent(0, side);
    const LatticePoint low = {corner(random_), corner(random_), corner(random_)};
    return {low, {low.x + extent(random_), low.y + extent(random_), low.z + extent(random_)}};
  }
  std::uint32_t below(std::uint32_t count) { return static_cast<std::uint32_t>(random_() % count); }

 private:
  std::mt19937_64 random_{7};
};

std::set<std::uint32_t> near(const TriangleTree& tree, const TriangleBox& box) {
  std::set<std::uint32_t> found;
  tree.visit_near(box, [&](std::uint32_t t) {
    EXPECT_TRUE(found.insert(t).second) << "Visited twice.";
    return false;
  });
  return found;
}

TEST(TriangleTree, FindsTrianglesThatTouchABoxAfterMovesAndRemovals) {
  for (const std::uint32_t count : {1U, 8U, 9U, 65U, 700U}) {
    RandomBoxes random;
    std::vector<TriangleBox> boxes;
    for (std::uint32_t t = 0; t < count; ++t) boxes.push_back(random.box());
    TriangleTree tree(boxes);
    std::vector<std::optional<TriangleBox>> expected(boxes.begin(), boxes.end());
    for (int i = 0; i < 600; ++i) {
      const TriangleBox at = random.box();
      std::set<std::uint32_t> touching;
      for (std::uint32_t t = 0; t < count; ++t) {
        if (expected[t] && expected[t]->touches(at)) touching.insert(t);
      }
      ASSERT_EQ(near(tree, at), touching) << count << " " << i;
      const std::uint32_t t = random.below(count);
      if (i % 3 == 0 && expected[t]) {
        tree.remove(t);
        expected[t].reset();
      } else {
        expected[t] = random.box();
        tree.set(t, *expected[t]);
      }
    }
  }
}

TEST(TriangleTree, StopsWhenTheVisitorStops) {
  RandomBoxes random;
  std::vector<TriangleBox> boxes(100, random.box());
  const TriangleTree tree(boxes);
  int visited = 0;
  EXPECT_TRUE(tree.visit_near(boxes[0], [&](std::uint32_t) { return ++visited == 5; }));
  EXPECT_EQ(visited, 5);
}

}  // namespace
}  // namespace multitetra
