// Distances between two surfaces, from sample points on each to the triangles of the other.
//
//   const NearestTriangle full(std::move(full_triangles));
//   const DistanceStatistics there = distances(sampled_points(mesh, 20'000), full, limit);
//
// Surfaces are sets of triangles in any coordinates and unit of length; degenerate triangles count
// as points or segments. Deterministic; only the choice of samples depends on the triangles' order.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "common/base/vec3.hpp"
#include "common/mesh/box_tree.hpp"

namespace multitetra {

using SurfaceTriangle = std::array<Vec3, 3>;

[[nodiscard]] double distance_to_triangle(const Vec3& point, const SurfaceTriangle& triangle);

// Returns `count` points distributed over the surface by area: the sequence of triangles is divided
// into `count` parts of equal area, and each part gives one point. Empty if the area is 0.
[[nodiscard]] std::vector<Vec3> sampled_points(std::span<const SurfaceTriangle> surface,
                                               std::size_t count, std::uint64_t seed = 1);

// Finds the distance of points to a surface. Immutable and therefore thread-safe. Takes about 110
// bytes per triangle; a query costs O(log triangles) if the point is near.
class NearestTriangle {
 public:
  explicit NearestTriangle(std::span<const SurfaceTriangle> triangles);

  struct Found {
    double distance = std::numeric_limits<double>::infinity();
    // Valid as long as this object; null if there is no triangle.
    const SurfaceTriangle* triangle = nullptr;
  };
  [[nodiscard]] Found nearest(const Vec3& point) const;
  // Infinite if there is no triangle.
  [[nodiscard]] double distance(const Vec3& point) const { return nearest(point).distance; }
  [[nodiscard]] bool is_empty() const { return triangles_.empty(); }

 private:
  BoxTree tree_;
  std::vector<SurfaceTriangle> triangles_;  // In the tree's order.
};

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
[[nodiscard]] DistanceStatistics distances(std::span<const Vec3> points,
                                           const NearestTriangle& surface,
                                           const DistanceLimit& limit);

}  // namespace multitetra
