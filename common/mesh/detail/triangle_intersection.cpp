#include "common/mesh/detail/triangle_intersection.hpp"

#include <algorithm>

#include "common/mesh/detail/exact_predicates.hpp"

namespace multitetra {
namespace {

using Corners = std::array<Vec3, 3>;

// Projects along an axis.
Vec2 project(const Vec3& p, std::size_t axis) { return {p[(axis + 1) % 3], p[(axis + 2) % 3]}; }

// A projection axis in which the triangle has an area, and the orientation of its corners there; 0
// if the triangle is flat.
struct Projection {
  std::size_t axis = 0;
  int sign = 0;
};
Projection projection_of(const Corners& t) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int sign = orientation(project(t[0], axis), project(t[1], axis), project(t[2], axis));
    if (sign != 0) return {axis, sign};
  }
  return {};
}

// Returns whether p, on the line through a and b, lies between them, ends included.
bool is_between(const Vec2& a, const Vec2& b, const Vec2& p) {
  return std::min(a[0], b[0]) <= p[0] && p[0] <= std::max(a[0], b[0]) &&
         std::min(a[1], b[1]) <= p[1] && p[1] <= std::max(a[1], b[1]);
}

bool segments_meet(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  const int abc = orientation(a, b, c);
  const int abd = orientation(a, b, d);
  const int cda = orientation(c, d, a);
  const int cdb = orientation(c, d, b);
  if (abc * abd < 0 && cda * cdb < 0) return true;
  return (abc == 0 && is_between(a, b, c)) || (abd == 0 && is_between(a, b, d)) ||
         (cda == 0 && is_between(c, d, a)) || (cdb == 0 && is_between(c, d, b));
}

// Returns whether a segment in the plane of the triangle meets it.
bool meets_in_plane(const Vec3& p, const Vec3& q, const Corners& t) {
  const Projection projection = projection_of(t);
  const std::array<Vec2, 3> corners = {project(t[0], projection.axis),
                                       project(t[1], projection.axis),
                                       project(t[2], projection.axis)};
  const Vec2 a = project(p, projection.axis);
  const Vec2 b = project(q, projection.axis);
  bool contains = true;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec2& from = corners[i];
    const Vec2& to = corners[(i + 1) % 3];
    if (segments_meet(a, b, from, to)) return true;
    contains = contains && orientation(from, to, a) == projection.sign;
  }
  return contains;
}

// Returns whether the closed segment and the closed triangle share a point. `side_p` and `side_q`
// are the sides of the triangle's plane on which p and q lie.
bool meets(const Vec3& p, const Vec3& q, int side_p, int side_q, const Corners& t) {
  if (side_p * side_q > 0) return false;
  if (side_p == 0 && side_q == 0) return meets_in_plane(p, q, t);
  int least = 1;
  int greatest = -1;
  for (std::size_t i = 0; i < 3; ++i) {
    const int sign = orientation(p, q, t[i], t[(i + 1) % 3]);
    least = std::min(least, sign);
    greatest = std::max(greatest, sign);
  }
  return least >= 0 || greatest <= 0;
}

int side_of(const Vec3& p, const Corners& t) { return orientation(t[0], t[1], t[2], p); }

bool meets(const Vec3& p, const Vec3& q, const Corners& t) {
  return meets(p, q, side_of(p, t), side_of(q, t), t);
}

bool any_side_meets(const Corners& sides, const std::array<int, 3>& side_of_corner,
                    const Corners& t) {
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    if (meets(sides[i], sides[j], side_of_corner[i], side_of_corner[j], t)) return true;
  }
  return false;
}

std::array<int, 3> sides_of(const Corners& corners, const Corners& t) {
  return {side_of(corners[0], t), side_of(corners[1], t), side_of(corners[2], t)};
}

bool is_on_one_side(const std::array<int, 3>& sides) {
  return sides[0] != 0 && sides[0] == sides[1] && sides[1] == sides[2];
}

bool disjoint_triangles_meet(const Corners& a, const Corners& b) {
  const std::array<int, 3> of_a = sides_of(a, b);
  if (is_on_one_side(of_a)) return false;
  const std::array<int, 3> of_b = sides_of(b, a);
  if (is_on_one_side(of_b)) return false;
  return any_side_meets(a, of_a, b) || any_side_meets(b, of_b, a);
}

// Returns the first corner that `other` does not have, or 0.
std::size_t own_corner(const MeshTriangle& of, const MeshTriangle& other) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (std::find(other.vertices.begin(), other.vertices.end(), of.vertices[i]) ==
        other.vertices.end()) {
      return i;
    }
  }
  return 0;
}

// Coplanar triangles on the same side of their common edge overlap; other neighbors do not.
bool neighbours_overlap(const MeshTriangle& a, const MeshTriangle& b) {
  const std::size_t i = own_corner(a, b);
  const Vec3& own = a.positions[i];
  const Vec3& other = b.positions[own_corner(b, a)];
  if (side_of(other, a.positions) != 0) return false;
  const Projection projection = projection_of(a.positions);
  const Vec2 from = project(a.positions[(i + 1) % 3], projection.axis);
  const Vec2 to = project(a.positions[(i + 2) % 3], projection.axis);
  return orientation(from, to, project(own, projection.axis)) ==
         orientation(from, to, project(other, projection.axis));
}

// Triangles with a common vertex that share further points share a segment from there or an area,
// which reaches the opposite side of one of them.
bool meet_beyond_vertex(const MeshTriangle& a, std::size_t shared_in_a, const MeshTriangle& b,
                        std::size_t shared_in_b) {
  const auto opposite_meets = [](const Corners& of, std::size_t shared, const Corners& other) {
    return meets(of[(shared + 1) % 3], of[(shared + 2) % 3], other);
  };
  return opposite_meets(a.positions, shared_in_a, b.positions) ||
         opposite_meets(b.positions, shared_in_b, a.positions);
}

}  // namespace

bool is_flat(const std::array<Vec3, 3>& positions) { return projection_of(positions).sign == 0; }

bool intersect(const MeshTriangle& a, const MeshTriangle& b) {
  std::size_t shared = 0;
  std::size_t in_a = 0;
  std::size_t in_b = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      if (a.vertices[i] != b.vertices[j]) continue;
      ++shared;
      in_a = i;
      in_b = j;
    }
  }
  if (shared == 0) return disjoint_triangles_meet(a.positions, b.positions);
  if (shared == 1) return meet_beyond_vertex(a, in_a, b, in_b);
  return shared == 3 || neighbours_overlap(a, b);
}

}  // namespace multitetra
