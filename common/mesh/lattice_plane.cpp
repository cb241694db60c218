#include "common/mesh/lattice_plane.hpp"

#include <cstddef>
#include <utility>

namespace multitetra {
namespace {

using Number = LatticePlane::Number;
using Direction = LatticePlane::Direction;
using Sides = std::array<Number, 3>;

Direction direction(const LatticePoint& from, const LatticePoint& to) {
  return {Number{to.x} - from.x, Number{to.y} - from.y, Number{to.z} - from.z};
}

Direction product(const Direction& a, const Direction& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Number product_along(const Direction& a, const Direction& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

bool are_beyond(Number a, Number b) { return (a > 0 && b > 0) || (a < 0 && b < 0); }

bool is_around(Number a, Number b, Number c) {
  return (a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0);
}

bool is_corner(const LatticePoint& p, const LatticeTriangle& t) {
  return p == t[0] || p == t[1] || p == t[2];
}

// Returns whether a triangle, whose corners lie on these sides of the other's plane, meets that
// plane only in shared corners. The triangles then have nothing else in common.
bool touches_only_shared_corners(const LatticeTriangle& t, const Sides& sides,
                                 const LatticeTriangle& other) {
  bool is_above = false;
  bool is_below = false;
  for (const Number side : sides) {
    is_above = is_above || side > 0;
    is_below = is_below || side < 0;
  }
  if (is_above == is_below) return false;
  for (std::size_t i = 0; i < 3; ++i) {
    if (sides[i] == 0 && !is_corner(t[i], other)) return false;
  }
  return true;
}

// Returns twice the signed area of a triangle in the plane, projected along the normal's main axis.
Number turn(const LatticePlane& plane, const LatticePoint& p, const LatticePoint& q,
            const LatticePoint& r) {
  const auto size = [&](std::size_t i) {
    return plane.normal()[i] < 0 ? -plane.normal()[i] : plane.normal()[i];
  };
  const std::size_t axis =
      size(0) >= size(1) && size(0) >= size(2) ? 0U : (size(1) >= size(2) ? 1U : 2U);
  return product(direction(p, q), direction(p, r))[axis];
}

// Returns whether the triangle contains a point of its plane.
bool contains(const LatticePlane& plane, const LatticePoint& p) {
  const LatticeTriangle& t = plane.triangle();
  return is_around(turn(plane, t[0], t[1], p), turn(plane, t[1], t[2], p),
                   turn(plane, t[2], t[0], p));
}

// Returns whether a segment in the triangle's plane meets the triangle. Edges collinear with the
// segment can be skipped: it then also meets another edge or has an end in the triangle.
bool meets_in_plane(const LatticePlane& plane, const LatticePoint& p, const LatticePoint& q) {
  if (contains(plane, p) || contains(plane, q)) return true;
  for (std::size_t i = 0; i < 3; ++i) {
    const LatticePoint& a = plane.triangle()[i];
    const LatticePoint& b = plane.triangle()[(i + 1) % 3];
    const Number a_side = turn(plane, p, q, a);
    const Number b_side = turn(plane, p, q, b);
    if (a_side == 0 && b_side == 0) continue;
    if (!are_beyond(a_side, b_side) && !are_beyond(turn(plane, a, b, p), turn(plane, a, b, q))) {
      return true;
    }
  }
  return false;
}

// Returns whether a segment, whose ends lie on these sides of the plane, meets the triangle.
bool meets(const LatticePlane& plane, const LatticePoint& p, const LatticePoint& q,
           Number side_of_p, Number side_of_q) {
  if (are_beyond(side_of_p, side_of_q)) return false;
  if (side_of_p == 0 && side_of_q == 0) return meets_in_plane(plane, p, q);
  const Direction along = direction(p, q);
  const Direction a = direction(p, plane.triangle()[0]);
  const Direction b = direction(p, plane.triangle()[1]);
  const Direction c = direction(p, plane.triangle()[2]);
  return is_around(product_along(along, product(a, b)), product_along(along, product(b, c)),
                   product_along(along, product(c, a)));
}

// Returns whether an edge of `t` that ends in no corner of the other triangle meets that triangle.
bool any_edge_meets(const LatticeTriangle& t, const Sides& sides, const LatticePlane& other) {
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    if (is_corner(t[i], other.triangle()) || is_corner(t[j], other.triangle())) continue;
    if (meets(other, t[i], t[j], sides[i], sides[j])) return true;
  }
  return false;
}

// Returns whether triangles in one plane with two common corners overlap: they do if they lie on
// the same side of their common edge.
bool overlap_in_plane(const LatticeTriangle& a, const LatticeTriangle& b) {
  LatticePoint first, second;  // The corners that are not common.
  for (const LatticePoint& p : a) {
    if (!is_corner(p, b)) first = p;
  }
  for (const LatticePoint& p : b) {
    if (!is_corner(p, a)) second = p;
  }
  const std::size_t at = first == a[0] ? 0U : (first == a[1] ? 1U : 2U);
  const LatticePoint& begin = a[(at + 1) % 3];
  const Direction edge = direction(begin, a[(at + 2) % 3]);
  const Direction one = product(edge, direction(begin, first));
  const Direction two = product(edge, direction(begin, second));
  for (std::size_t i = 0; i < 3; ++i) {
    if (one[i] != 0) return are_beyond(one[i], two[i]);
  }
  return true;
}

}  // namespace

LatticePlane::LatticePlane(const LatticeTriangle& triangle)
    : triangle_(triangle),
      normal_(product(direction(triangle[0], triangle[1]), direction(triangle[0], triangle[2]))) {}

bool intersect(const LatticePlane& a, const LatticePlane& b) {
  const LatticeTriangle& t = a.triangle();
  const LatticeTriangle& o = b.triangle();
  const Sides t_sides = {b.side(t[0]), b.side(t[1]), b.side(t[2])};
  if (touches_only_shared_corners(t, t_sides, o)) return false;
  const Sides o_sides = {a.side(o[0]), a.side(o[1]), a.side(o[2])};
  if (touches_only_shared_corners(o, o_sides, t)) return false;
  const int common = is_corner(t[0], o) + is_corner(t[1], o) + is_corner(t[2], o);
  if (common == 3) return true;
  // With a common edge, triangles intersect only if coplanar: else their planes share just a line.
  if (common == 2) {
    return t_sides == Sides{0, 0, 0} && overlap_in_plane(t, o);
  }
  // With a common corner, a further intersection ends on the edge opposite to it in one of them.
  return any_edge_meets(t, t_sides, b) || any_edge_meets(o, o_sides, a);
}

}  // namespace multitetra
