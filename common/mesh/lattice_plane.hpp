// Exact intersection tests for triangles on the lattice, in integers.
//
//   const LatticePlane a(one), b(other);
//   if (intersect(a, b)) ...
#pragma once

#include <array>
#include <cstdint>

#include "common/mesh/mesh.hpp"

namespace multitetra {

// A non-degenerate triangle and its plane. Lattice coordinates are within 0 .. 2^kMaxLatticeBits.
class LatticePlane {
 public:
  // Coordinate differences are at most 2^20, so a determinant, a sum of six products of three of
  // them, stays below 2^63.
  static_assert(kMaxLatticeBits <= 20);
  using Number = std::int64_t;
  using Direction = std::array<Number, 3>;

  explicit LatticePlane(const LatticeTriangle& triangle);

  [[nodiscard]] const LatticeTriangle& triangle() const { return triangle_; }
  [[nodiscard]] const Direction& normal() const { return normal_; }
  // Returns the point's side: 0 on the plane, positive in the normal's direction.
  [[nodiscard]] Number side(const LatticePoint& p) const {
    return normal_[0] * (p.x - triangle_[0].x) + normal_[1] * (p.y - triangle_[0].y) +
           normal_[2] * (p.z - triangle_[0].z);
  }

 private:
  LatticeTriangle triangle_;
  Direction normal_;
};

// A quick test: returns whether the triangle meets the plane only in corners shared by both
// triangles and otherwise lies on one side. The triangles then do not intersect.
[[nodiscard]] inline bool touches_only_shared_corners(const LatticePlane& plane,
                                                      const LatticeTriangle& triangle) {
  bool is_above = false;
  bool is_below = false;
  for (const LatticePoint& p : triangle) {
    const LatticePlane::Number side = plane.side(p);
    const auto& [q, r, s] = plane.triangle();
    if (side == 0 && p != q && p != r && p != s) return false;
    is_above = is_above || side > 0;
    is_below = is_below || side < 0;
  }
  return is_above != is_below;
}

// Returns whether two triangles have a common point outside the vertices or edge they share.
// Touching counts.
[[nodiscard]] bool intersect(const LatticePlane& a, const LatticePlane& b);

}  // namespace multitetra
