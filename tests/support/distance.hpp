// Distances between small meshes, by brute force.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "common/base/affine.hpp"
#include "common/base/vec3.hpp"

namespace multitetra::testing {

using Triangle = std::array<Vec3, 3>;

inline Vec3 operator-(const Vec3& a, const Vec3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Vec3 operator+(const Vec3& a, const Vec3& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
inline Vec3 operator*(double s, const Vec3& a) { return {s * a[0], s * a[1], s * a[2]}; }

inline double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a;
  const double t = std::clamp(dot(p - a, ab) / dot(ab, ab), 0.0, 1.0);
  return length(p - (a + t * ab));
}

// Returns the distance to the plane if the projection lies inside the triangle, otherwise to the
// nearest side.
inline double distance_to_triangle(const Vec3& p, const Triangle& t) {
  const Vec3 normal = cross(t[1] - t[0], t[2] - t[0]);
  bool inside = dot(normal, normal) > 0;
  double nearest_side = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3& a = t[i];
    const Vec3& b = t[(i + 1) % 3];
    inside = inside && dot(cross(b - a, p - a), normal) >= 0;
    nearest_side = std::min(nearest_side, distance_to_segment(p, a, b));
  }
  return inside ? std::abs(dot(p - t[0], normal)) / length(normal) : nearest_side;
}

// Answers distances from points to a triangle soup.
class DistanceToSurface {
 public:
  explicit DistanceToSurface(const std::vector<Triangle>& triangles) : triangles_(triangles) {
    for (const Triangle& t : triangles)
      reach_.push_back(std::max(length(t[1] - t[0]), length(t[2] - t[0])));
  }
  [[nodiscard]] double operator()(const Vec3& p) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      const Vec3 d = p - triangles_[i][0];
      const double near_enough = nearest + reach_[i];
      if (dot(d, d) < near_enough * near_enough) {
        nearest = std::min(nearest, distance_to_triangle(p, triangles_[i]));
      }
    }
    return nearest;
  }

 private:
  const std::vector<Triangle>& triangles_;
  std::vector<double> reach_;  // From a triangle's first corner to its farthest one.
};

// Returns the largest distance from the corners and centers of one surface's triangles to the other
// surface.
inline double one_sided_distance(const std::vector<Triangle>& from,
                                 const std::vector<Triangle>& to) {
  const DistanceToSurface distance(to);
  double largest = 0;
  for (const Triangle& t : from) {
    const Vec3 center = (1.0 / 3) * (t[0] + t[1] + t[2]);
    for (const Vec3& p : {t[0], t[1], t[2], center}) largest = std::max(largest, distance(p));
  }
  return largest;
}

}  // namespace multitetra::testing
