// Nearest points of two segments, and of a point and a triangle.
#pragma once

#include <algorithm>

#include "common/affine.hpp"
#include "server/core/vectors.hpp"

namespace multitetra {

// Where on a segment from `a` along `ab`, as a part of it, the point nearest to p lies.
[[nodiscard]] inline double nearest_part(const Vec3& p, const Vec3& a, const Vec3& ab) {
  const double squared = squared_length(ab);
  if (squared == 0) return 0;
  return std::clamp(inner_product(difference(p, a), ab) / squared, 0.0, 1.0);
}

[[nodiscard]] inline double squared_distance_to_segment(const Vec3& p, const Vec3& a,
                                                        const Vec3& ab) {
  return squared_length(difference(p, moved(a, nearest_part(p, a, ab), ab)));
}

// Where two segments a + s ab and c + t cd are nearest to each other.
struct NearestParts {
  double s = 0;
  double t = 0;
  double squared_distance = 0;
};
[[nodiscard]] inline NearestParts nearest_parts(const Vec3& a, const Vec3& ab, const Vec3& c,
                                                const Vec3& cd) {
  const Vec3 ca = difference(a, c);
  const double aa = squared_length(ab);
  const double bb = squared_length(cd);
  const double mixed = inner_product(ab, cd);
  const double along_first = inner_product(ab, ca);
  const double determinant = aa * bb - mixed * mixed;
  NearestParts parts;
  if (determinant > 1e-12 * aa * bb) {
    parts.s =
        std::clamp((mixed * inner_product(cd, ca) - along_first * bb) / determinant, 0.0, 1.0);
  }
  parts.t = nearest_part(moved(a, parts.s, ab), c, cd);
  parts.s = nearest_part(moved(c, parts.t, cd), a, ab);
  parts.squared_distance = squared_length(difference(moved(a, parts.s, ab), moved(c, parts.t, cd)));
  return parts;
}

}  // namespace multitetra
