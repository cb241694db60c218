// Compares the distances of points and edges to a fan with brute-force distances.
#include "server/core/simplification/detail/collapse_fan.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "common/base/vec3.hpp"
#include "common/mesh/surface_distance.hpp"

namespace multitetra {
namespace {

class RandomFans {
 public:
  Vec3 point() { return {coordinate_(random_), coordinate_(random_), coordinate_(random_)}; }
  std::vector<Vec3> ring() {
    std::vector<Vec3> ring(3 + random_() % 6);
    for (Vec3& corner : ring) corner = point();
    return ring;
  }

 private:
  std::mt19937_64 random_{7};
  std::uniform_real_distribution<double> coordinate_{-1, 1};
};

double distance_to_sector(const Vec3& point, const std::vector<Vec3>& ring, std::uint32_t sector) {
  return distance_to_triangle(point, {ring[0], ring[sector], ring[sector + 1]});
}

double distance_to_fan(const Vec3& point, const std::vector<Vec3>& ring) {
  double least = std::numeric_limits<double>::infinity();
  for (std::uint32_t k = 1; k + 1 < ring.size(); ++k) {
    least = std::min(least, distance_to_sector(point, ring, k));
  }
  return least;
}

TEST(CollapseFan, AcceptsPointsWithinTheLimitAndRecordsTheirDistance) {
  RandomFans random;
  CollapseFan fan;
  for (int i = 0; i < 3000; ++i) {
    const std::vector<Vec3> ring = random.ring();
    const Vec3 point = random.point();
    const double distance = distance_to_fan(point, ring);
    fan.set_up(ring, 0.99 * distance);
    EXPECT_FALSE(fan.sector_near({point}));
    EXPECT_EQ(fan.largest(), 0);
    fan.set_up(ring, 1.01 * distance);
    auto sector = fan.sector_near({point});
    ASSERT_TRUE(sector);
    ASSERT_LE(*sector, fan.sectors());
    // The sector straight below is tried first; it may be near without being the nearest.
    EXPECT_GE(fan.largest(), distance - 1e-9);
    EXPECT_LE(fan.largest(), 1.01 * distance);
    EXPECT_LE(distance_to_sector(point, ring, *sector), 1.01 * distance + 1e-9);
    fan.set_up(ring, 1e3);
    sector = fan.sector_near({point});
    ASSERT_TRUE(sector);
    EXPECT_GE(fan.largest(), distance_to_sector(point, ring, *sector) - 1e-9);
  }
}

TEST(CollapseFan, AcceptsEdgesWithinTheLimitOfASpoke) {
  RandomFans random;
  CollapseFan fan;
  for (int i = 0; i < 300; ++i) {
    const std::vector<Vec3> ring = random.ring();
    const Vec3 low = random.point();
    const Vec3 high = random.point();
    const SurfaceTriangle edge = {low, high, high};
    for (std::uint32_t k = 1; k < ring.size(); ++k) {
      double distance = std::numeric_limits<double>::infinity();
      for (int j = 0; j <= 1000; ++j) {
        const Vec3 on_spoke = moved(ring[0], j / 1000.0, difference(ring[k], ring[0]));
        distance = std::min(distance, distance_to_triangle(on_spoke, edge));
      }
      const double least = std::max(distance - 4e-3, 0.0);  // Allows for the sampling of the spoke.
      fan.set_up(ring, least);
      if (least > 0) {
        EXPECT_FALSE(fan.is_near({low}, {high}, k, k));
      }
      fan.set_up(ring, distance * (1 + 1e-9));
      EXPECT_TRUE(fan.is_near({low}, {high}, k, k));
      EXPECT_LE(fan.largest(), distance + 1e-9);
    }
  }
}

}  // namespace
}  // namespace multitetra
