// Distances between two surfaces, from sample points on each to the triangles of the other.
//
//   const NearestTriangle full(std::move(full_triangles));
//   for (const Vec3& point : sampled_points(mesh, 20'000)) largest = max(full.distance(point), ...);
//
// Surfaces are sets of triangles in any coordinates and unit of length; degenerate triangles count
// as points or segments. Deterministic; only the choice of samples depends on the triangles' order.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <stop_token>
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
  // Throws Cancelled soon after `stop` is triggered.
  explicit NearestTriangle(std::span<const SurfaceTriangle> triangles,
                           const std::stop_token& stop = {});

  struct Found {
    double distance = std::numeric_limits<double>::infinity();
    // Valid as long as this object; null if there is no triangle.
    const SurfaceTriangle* triangle = nullptr;
    std::uint32_t index = 0;  // Of the triangle, in the order given to the constructor.
  };
  // The search is shorter with a triangle of this surface that is near the point; it finds the
  // same.
  [[nodiscard]] Found nearest(const Vec3& point, const SurfaceTriangle* near = nullptr) const;
  // Infinite if there is no triangle.
  [[nodiscard]] double distance(const Vec3& point) const { return nearest(point).distance; }
  [[nodiscard]] bool is_empty() const { return triangles_.empty(); }

 private:
  BoxTree tree_;
  std::vector<SurfaceTriangle> triangles_;  // In the tree's order.
};

}  // namespace multitetra
