// Distances between two surfaces, from sampled points of each to all triangles of the other.
//
//   const NearestTriangle full(std::move(full_triangles));
//   const DistanceStatistics there = distances(sampled_points(mesh, 20'000), full, limit);
//
// Surfaces are sets of triangles in any coordinates and unit of length; degenerate triangles are
// points or segments and do no harm. Nothing depends on the order of the triangles but the choice
// of samples, and nothing on a clock: the same arguments give the same numbers.
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

// `count` points spread over the surface in proportion to its area: its triangles in their order
// are cut into `count` parts of equal area, and each part gives one point. None of a surface
// without area.
[[nodiscard]] std::vector<Vec3> sampled_points(std::span<const SurfaceTriangle> surface,
                                               std::size_t count, std::uint64_t seed = 1);

// Finds the distance of points to a surface. Immutable, so any thread may use it. Takes about 110
// bytes a triangle; a query costs O(log triangles) when the point is near.
class NearestTriangle {
 public:
  explicit NearestTriangle(std::span<const SurfaceTriangle> triangles);

  struct Found {
    double distance = std::numeric_limits<double>::infinity();
    const SurfaceTriangle* triangle = nullptr;  // As long as this object; none: there is none.
  };
  [[nodiscard]] Found nearest(const Vec3& point) const;
  // Infinite when there is no triangle.
  [[nodiscard]] double distance(const Vec3& point) const { return nearest(point).distance; }
  [[nodiscard]] bool is_empty() const { return triangles_.empty(); }

 private:
  BoxTree tree_;
  std::vector<SurfaceTriangle> triangles_;  // In the order of the tree.
};

// The allowed distance at a place, in the surfaces' coordinates and unit.
using DistanceLimit = std::function<double(const Vec3& place)>;

struct DistanceStatistics {
  std::uint64_t samples = 0;
  double maximum = 0;
  double percentile_99 = 0;
  double mean = 0;
  // Where the distance is largest against what is allowed there, and what is allowed there.
  double worst_distance = 0;
  double worst_limit = 0;
  Vec3 worst_place = {0, 0, 0};
  std::uint64_t above_limit = 0;  // Samples that are farther than allowed.
};

// The distances of the points from the surface. All zero without points; without surface all are
// infinite.
[[nodiscard]] DistanceStatistics distances(std::span<const Vec3> points,
                                           const NearestTriangle& surface,
                                           const DistanceLimit& limit);

}  // namespace multitetra
