#include "server/core/fine_errors/detail/mixed_diamonds.hpp"

#include <gtest/gtest.h>

#include <random>

#include "server/core/framework/diamond.hpp"

namespace multitetra {
namespace {

constexpr std::int32_t kCells = 3;
constexpr std::int32_t kSide = 8 * kCells;

// Random bits over three cells a side, as points and as planes. The tests examine the middle cell.
struct Bits {
  Bits(std::uint64_t seed, double density) {
    std::mt19937_64 random(seed);
    std::bernoulli_distribution is_set(density);
    grid.begin(kCells);
    for (std::int32_t z = 0; z < kSide; ++z) {
      for (std::int32_t y = 0; y < kSide; ++y) {
        for (std::int32_t x = 0; x < kSide; ++x) {
          const bool bit = is_set(random);
          points.push_back(bit);
          grid.plane(grid.cell(x / 8, y / 8, z / 8), z % 8) |= BitPlane{bit}
                                                               << (x % 8 + 8 * (y % 8));
        }
      }
    }
  }
  [[nodiscard]] bool at(GridPoint p) const {
    return points[static_cast<std::size_t>(p.x + kSide * (p.y + kSide * p.z))];
  }
  [[nodiscard]] bool any_in_diamond(const DividingPoint& point) const {
    const auto [a, b] = point.split_edge();
    bool any = at(point.at()) || at(a) || at(b);
    const PointList<8> ring = point.ring();
    for (const GridPoint corner : ring) any |= at(corner);
    return any;
  }

  std::vector<bool> points;
  BitGrid grid;
};

// Calls `visit(point, layer, bit)` for the points of spacing 1, 2 and 4 in the middle cell.
template <typename Visit>
void visit_points(const Visit& visit) {
  for (std::int32_t i = 1; i < 512; ++i) {
    const GridPoint p = {8 + i % 8, 8 + i / 8 % 8, 8 + i / 64};
    visit(DividingPoint(p), i / 64, i % 64);
  }
}

TEST(MixedDiamonds, NeedABitOfEachKind) {
  for (const double density : {0.02, 0.1, 0.5}) {
    const Bits above(1, density);
    const Bits below(2, density);
    const std::array<BitPlane, 8> mixed =
        mixed_diamonds(above.grid, below.grid, above.grid.cell(1, 1, 1));
    EXPECT_EQ(mixed[0] & 1, 0U);  // The spacing of this point is larger.
    visit_points([&](const DividingPoint& point, std::int32_t z, std::int32_t bit) {
      EXPECT_EQ(mixed[static_cast<std::size_t>(z)] >> bit & 1,
                above.any_in_diamond(point) && below.any_in_diamond(point) ? 1U : 0U);
    });
  }
}

TEST(LayerPoints, HaveKindSpacingAndChildren) {
  const Grid grid(5);
  for (const double density : {0.02, 0.2}) {
    const Bits bits(3, density);
    visit_points([&](const DividingPoint& point, std::int32_t z, std::int32_t bit) {
      for (int exponent = 0; exponent < 3; ++exponent) {
        if (z % (1 << exponent) != 0) continue;
        for (const PointKind kind : {PointKind::kEdge, PointKind::kFace, PointKind::kCube}) {
          const bool is_one = point.kind() == kind && point.spacing() == 1 << exponent;
          EXPECT_EQ(points_of_kind(kind, z, exponent) >> bit & 1, is_one ? 1U : 0U);
          bool has_child = false;
          if (is_one) {
            const PointList<8> children = point.children(grid);
            for (const GridPoint child : children) has_child |= bits.at(child);
          }
          EXPECT_EQ(with_children(bits.grid, bits.grid.cell(1, 1, 1), z, exponent, kind) >> bit & 1,
                    has_child ? 1U : 0U);
        }
      }
    });
  }
}

}  // namespace
}  // namespace multitetra
