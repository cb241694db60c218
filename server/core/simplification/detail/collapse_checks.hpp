// Collapses that are rejected for any distance. `ring` contains the corners around u starting at
// the target w_0, as in collapsing_mesh.hpp; `ring_positions` are the positions of w_0, w_1, ...
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "common/base/vec3.hpp"
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

}  // namespace multitetra
