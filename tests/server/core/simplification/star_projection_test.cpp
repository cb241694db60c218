// Checks stars that the projection clears by comparing all pairs of their triangles.
#include "server/core/simplification/detail/star_projection.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "common/mesh/lattice_plane.hpp"

namespace multitetra {
namespace {

// Returns whether two triangles (center, around[i], around[i + 1]) of a star intersect.
bool intersects_itself(const LatticePoint& center, const std::vector<LatticePoint>& around) {
  std::vector<LatticePlane> planes;
  for (std::size_t i = 0; i < around.size(); ++i) {
    planes.emplace_back(LatticeTriangle{center, around[i], around[(i + 1) % around.size()]});
  }
  for (std::size_t i = 0; i < planes.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (intersect(planes[i], planes[j])) return true;
    }
  }
  return false;
}

bool is_disjoint_star(const LatticePoint& center, const std::vector<LatticePoint>& around) {
  OrientationMask turns;
  for (std::size_t i = 0; i < around.size(); ++i) {
    turns.intersect(OrientationMask(
        LatticePlane({center, around[i], around[(i + 1) % around.size()]}).normal()));
  }
  return turns.any() && winds_once(center, around, turns);
}

TEST(StarProjection, NeverClearsStarsThatIntersectThemselves) {
  std::mt19937_64 random(11);
  std::uniform_int_distribution<std::int32_t> off(-6, 6);
  const LatticePoint center = {100, 100, 100};
  int clear = 0, crossing = 0;
  for (int i = 0; i < 200'000; ++i) {
    const auto count = 3 + random() % 5;
    std::vector<LatticePoint> around;
    for (std::size_t k = 0; k < count; ++k) {
      around.push_back({center.x + off(random), center.y + off(random), center.z + off(random)});
    }
    if (is_disjoint_star(center, around)) {
      ++clear;
      ASSERT_FALSE(intersects_itself(center, around)) << i;
    } else {
      ++crossing;
    }
  }
  EXPECT_GT(clear, 200);
  EXPECT_GT(crossing, 1000);
}

TEST(StarProjection, ClearsFlatStarsInAnyOrientation) {
  const LatticePoint center = {5000, 5000, 5000};
  std::mt19937_64 random(12);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 500; ++i) {
    // Two orthogonal directions.
    double a[3], b[3];
    double along = 0, squared = 0;
    for (std::size_t k = 0; k < 3; ++k) a[k] = normal(random), b[k] = normal(random);
    for (std::size_t k = 0; k < 3; ++k) along += a[k] * b[k], squared += a[k] * a[k];
    double length = 0;
    for (std::size_t k = 0; k < 3; ++k) b[k] -= along / squared * a[k], length += b[k] * b[k];
    std::vector<LatticePoint> around;
    for (int k = 0; k < 6; ++k) {
      const double angle = k * 3.14159265358979 / 3;
      const double s = 1000 * std::cos(angle) / std::sqrt(squared);
      const double t = 1000 * std::sin(angle) / std::sqrt(length);
      around.push_back({center.x + static_cast<std::int32_t>(s * a[0] + t * b[0]),
                        center.y + static_cast<std::int32_t>(s * a[1] + t * b[1]),
                        center.z + static_cast<std::int32_t>(s * a[2] + t * b[2])});
    }
    EXPECT_TRUE(is_disjoint_star(center, around)) << i;
  }
}

TEST(StarProjection, RejectsStarsThatWindTwiceOrReverse) {
  const LatticePoint center = {10, 10, 10};
  const auto at = [](std::int32_t x, std::int32_t y) { return LatticePoint{10 + x, 10 + y, 10}; };
  EXPECT_TRUE(is_disjoint_star(center, std::vector{at(4, 0), at(0, 4), at(-4, 0), at(0, -4)}));
  EXPECT_FALSE(is_disjoint_star(
      center, std::vector{at(4, 0), at(-3, 3), at(-3, -3), at(4, 1), at(-4, 3), at(-4, -3)}));
  EXPECT_FALSE(is_disjoint_star(center, std::vector{at(4, 0), at(0, 4), at(2, 2), at(0, -4)}));
  EXPECT_FALSE(is_disjoint_star(center, std::vector{at(4, 0), at(0, 4)}));
}

}  // namespace
}  // namespace multitetra
