// Statistics of the distances of points from a surface.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "common/mesh/surface_distance.hpp"

namespace multitetra {

// The allowed distance at a place, in the surfaces' coordinates and unit.
using DistanceLimit = std::function<double(const Vec3& place)>;

struct DistanceStatistics {
  std::uint64_t samples = 0;
  double maximum = 0;
  double percentile_99 = 0;
  double mean = 0;
  // The sample with the largest excess over its allowed distance, and that allowed distance.
  double worst_distance = 0;
  double worst_limit = 0;
  Vec3 worst_place = {0, 0, 0};
  std::uint64_t above_limit = 0;  // Samples farther than allowed.
};

// Returns statistics of the points' distances from the surface. All zero without points; infinite
// without a surface.
inline DistanceStatistics distances(std::span<const Vec3> points, const NearestTriangle& surface,
                                    const DistanceLimit& limit) {
  DistanceStatistics statistics{.samples = points.size()};
  if (points.empty()) return statistics;
  std::vector<double> all;
  all.reserve(points.size());
  double sum = 0;
  double worst_excess = -std::numeric_limits<double>::infinity();
  for (const Vec3& point : points) {
    const double distance = surface.distance(point);
    const double allowed = limit(point);
    all.push_back(distance);
    sum += distance;
    if (distance > allowed) ++statistics.above_limit;
    if (distance - allowed > worst_excess) {
      worst_excess = distance - allowed;
      statistics.worst_distance = distance;
      statistics.worst_limit = allowed;
      statistics.worst_place = point;
    }
  }
  statistics.mean = sum / static_cast<double>(points.size());
  statistics.maximum = *std::max_element(all.begin(), all.end());
  const auto rank =
      static_cast<std::ptrdiff_t>(std::ceil(0.99 * static_cast<double>(points.size())) - 1);
  std::nth_element(all.begin(), all.begin() + rank, all.end());
  statistics.percentile_99 = all[static_cast<std::size_t>(rank)];
  return statistics;
}

}  // namespace multitetra
