// Collapses that are rejected for any distance. `ring` contains the corners around u starting at
// the target w_0, as in collapsing_mesh.hpp; `ring_positions` are the positions of w_0, w_1, ...
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "common/base/vec3.hpp"
#include "common/mesh/lattice_plane.hpp"
#include "common/mesh/mesh.hpp"
#include "server/core/simplification/detail/collapsing_mesh.hpp"

namespace multitetra {

// Returns a normal as long as twice the triangle's area.
[[nodiscard]] inline Vec3 normal_of(const Vec3& p, const Vec3& q, const Vec3& r) {
  return cross(difference(q, p), difference(r, p));
}

// Returns whether the triangle of w_i and w_(i + 1) turns by more than about 78 degrees, or becomes
// degenerate, when its third vertex moves onto w_0. `before` is its current normal_of.
[[nodiscard]] inline bool turns_over(const Vec3& before, std::span<const Vec3> ring_positions,
                                     std::size_t i) {
  constexpr double kMinSquaredCosine = 0.04;
  const Vec3 after = normal_of(ring_positions[0], ring_positions[i], ring_positions[i + 1]);
  const double along = dot(before, after);
  return !(along > 0) ||
         along * along < kMinSquaredCosine * squared_length(before) * squared_length(after);
}

// Returns whether this holds for any triangle of the ring when u moves onto w_0.
[[nodiscard]] inline bool turns_over(const Vec3& u, std::span<const Vec3> ring_positions) {
  for (std::size_t i = 1; i + 1 < ring_positions.size(); ++i) {
    if (turns_over(normal_of(u, ring_positions[i], ring_positions[i + 1]), ring_positions, i))
      return true;
  }
  return false;
}

// Returns whether a new edge would connect two vertices of the border, or a new triangle three: the
// surface beyond the border may have the same edge or triangle.
[[nodiscard]] inline bool merges_boundaries(const CollapsingMesh& mesh,
                                            std::span<const std::uint32_t> ring) {
  const auto is_inner = [&](std::uint32_t corner) {
    return mesh.kind(mesh.vertex(CollapsingMesh::next(corner))) ==
           CollapsingMesh::VertexKind::kInner;
  };
  if (ring.size() == 3) return std::none_of(ring.begin(), ring.end(), is_inner);
  if (is_inner(ring[0])) return false;
  for (std::size_t i = 2; i + 1 < ring.size(); ++i) {
    if (!is_inner(ring[i])) return true;
  }
  return false;
}

// Returns whether the collapse would leave a closed component without volume: all of its vertices
// but u lie in one plane. Requires that turns_over() is false. Components of more triangles than
// can be expected in one plane are not searched.
[[nodiscard]] inline bool leaves_flat_component(const CollapsingMesh& mesh,
                                                std::span<const LatticePoint> vertices,
                                                std::span<const std::uint32_t> ring) {
  constexpr std::size_t kMaxTriangles = 64;
  const auto neighbour = [&](std::size_t i) {
    return vertices[mesh.vertex(CollapsingMesh::next(ring[i]))];
  };
  const LatticePlane plane({neighbour(0), neighbour(1), neighbour(2)});
  for (std::size_t i = 3; i < ring.size(); ++i) {
    if (plane.side(neighbour(i)) != 0) return false;
  }
  if (plane.side(vertices[mesh.vertex(ring[0])]) == 0) return false;  // As flat as before.
  std::vector<std::uint32_t> found;
  for (const std::uint32_t corner : ring) found.push_back(CollapsingMesh::triangle_of(corner));
  for (std::size_t i = 0; i < found.size(); ++i) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t across = mesh.opposite(CollapsingMesh::corner_of(found[i], k));
      if (across == CollapsingMesh::kNone) return false;
      const std::uint32_t triangle = CollapsingMesh::triangle_of(across);
      if (std::find(found.begin(), found.end(), triangle) != found.end()) continue;
      if (plane.side(vertices[mesh.vertex(across)]) != 0) return false;
      if (found.size() == kMaxTriangles) return false;
      found.push_back(triangle);
    }
  }
  return true;
}

// Returns whether the collapse would turn a small closed component inside out: its volume would
// change its sign or vanish. Larger components are not searched, whose volume a single collapse
// cannot cancel.
[[nodiscard]] inline bool inverts_component(const CollapsingMesh& mesh,
                                            std::span<const LatticePoint> vertices,
                                            std::span<const std::uint32_t> ring) {
  constexpr std::size_t kMaxTriangles = 16;
  constexpr std::size_t kMaxRing = 5;  // The mean of closed components of so few triangles is less.
  if (ring.size() > kMaxRing) return false;
  std::array<std::uint32_t, kMaxTriangles> found;
  std::size_t count = 0;
  for (const std::uint32_t corner : ring) found[count++] = CollapsingMesh::triangle_of(corner);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t across = mesh.opposite(CollapsingMesh::corner_of(found[i], k));
      if (across == CollapsingMesh::kNone) return false;
      const std::uint32_t triangle = CollapsingMesh::triangle_of(across);
      if (std::find(found.begin(), found.begin() + count, triangle) != found.begin() + count) {
        continue;
      }
      if (count == kMaxTriangles) return false;
      found[count++] = triangle;
    }
  }
  // Six times the volumes, exact. As seen from w_0, the triangles of w_0 have none; afterwards, nor
  // have those of u.
  const std::uint32_t u = mesh.vertex(ring[0]);
  const LatticePoint& goal = vertices[mesh.vertex(CollapsingMesh::next(ring[0]))];
  std::int64_t before = 0;
  std::int64_t after = 0;
  for (std::size_t i = 0; i < count; ++i) {
    std::array<std::array<std::int64_t, 3>, 3> p;
    bool has_u = false;
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t vertex = mesh.vertex(CollapsingMesh::corner_of(found[i], k));
      const LatticePoint& at = vertices[vertex];
      p[k] = {at.x - goal.x, at.y - goal.y, at.z - goal.z};
      for (const std::int64_t difference : p[k]) {
        constexpr std::int64_t kFar = 1 << 18;  // Sums of 16 determinants stay below 2^63.
        if (std::abs(difference) > kFar) return false;
      }
      has_u = has_u || vertex == u;
    }
    const std::int64_t volume = p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) +
                                p[0][1] * (p[1][2] * p[2][0] - p[1][0] * p[2][2]) +
                                p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]);
    before += volume;
    if (!has_u) after += volume;
  }
  return before > 0 ? after <= 0 : before < 0 && after >= 0;
}

}  // namespace multitetra
