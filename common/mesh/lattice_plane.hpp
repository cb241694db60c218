// Whether triangles on the lattice meet: exactly, in integers.
//
//   const LatticePlane a(one), b(other);
//   if (intersect(a, b)) ...
#pragma once

#include <array>
#include <cstdint>

#include "common/mesh/mesh.hpp"

namespace multitetra {

// A triangle with an area, and its plane. Lattice coordinates are within 0 .. 2^kMaxLatticeBits.
class LatticePlane {
 public:
  // Differences of lattice coordinates are at most 2^20, so products of three of them, six in a
  // determinant, stay below 2^63.
  static_assert(kMaxLatticeBits <= 20);
  using Number = std::int64_t;
  using Direction = std::array<Number, 3>;

  explicit LatticePlane(const LatticeTriangle& triangle);

  [[nodiscard]] const LatticeTriangle& triangle() const { return triangle_; }
  [[nodiscard]] const Direction& normal() const { return normal_; }
  // On which side of the plane it is: 0 in it, positive where the normal points.
  [[nodiscard]] Number side(const LatticePoint& p) const {
    return normal_[0] * (p.x - triangle_[0].x) + normal_[1] * (p.y - triangle_[0].y) +
           normal_[2] * (p.z - triangle_[0].z);
  }

 private:
  LatticeTriangle triangle_;
  Direction normal_;
};

// Whether the triangle meets the plane only in corners that both triangles have, and is on one side
// of it otherwise: then they do not intersect. Quickly found.
[[nodiscard]] inline bool is_beyond(const LatticePlane& plane, const LatticeTriangle& triangle) {
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

// Whether two triangles have a point in common beyond the vertices, or the edge, that they share.
// Touching counts.
[[nodiscard]] bool intersect(const LatticePlane& a, const LatticePlane& b);

}  // namespace multitetra
