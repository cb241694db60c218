// Collapses that are refused whatever the distance is. `ring` are the corners around u from the
// goal w_0 on, as in collapsing_mesh.hpp; `places` are where w_0, w_1, ... are.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "common/base/vec3.hpp"
#include "server/core/simplification/detail/collapsing_mesh.hpp"

namespace multitetra {

// As long as twice the triangle's area.
[[nodiscard]] inline Vec3 normal_of(const Vec3& p, const Vec3& q, const Vec3& r) {
  return cross(difference(q, p), difference(r, p));
}

// Whether the triangle of w_i and w_(i + 1) turns by more than some 78 degrees when its third
// vertex moves onto w_0, or becomes degenerate. `before` is its normal_of now.
[[nodiscard]] inline bool turns_over(const Vec3& before, std::span<const Vec3> places,
                                     std::size_t i) {
  constexpr double kLeastSquaredCosine = 0.04;
  const Vec3 after = normal_of(places[0], places[i], places[i + 1]);
  const double along = dot(before, after);
  return !(along > 0) ||
         along * along < kLeastSquaredCosine * squared_length(before) * squared_length(after);
}

// Whether any triangle of the ring does when u moves onto w_0.
[[nodiscard]] inline bool turns_over(const Vec3& u, std::span<const Vec3> places) {
  for (std::size_t i = 1; i + 1 < places.size(); ++i) {
    if (turns_over(normal_of(u, places[i], places[i + 1]), places, i)) return true;
  }
  return false;
}

// Whether a new edge would join two vertices of the border, or a new triangle three. The surface
// beyond the border may have such an edge or triangle too.
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
