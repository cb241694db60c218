// The isosurface inside one tetrahedron (marching tetrahedra), with vertices on the lattice.
//
// A corner is positive when its value is greater than the isovalue. One corner against three gives
// a triangle, two against two a quad, which is cut along its shorter diagonal: there is no
// ambiguous case, and what two neighbours see of their common face is the same. A tetrahedron with
// a void corner carries no surface.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <utility>

#include "common/mesh.hpp"
#include "server/core/grid.hpp"

namespace multitetra {

struct TetrahedronSurface {
  std::array<LatticeTriangle, 2> triangles;
  std::size_t count = 0;  // 0, 1 or 2
};

// How the surface lies in a tetrahedron whose corners' signs are known: which corners come first,
// so that positive ones precede, and whether that order is an odd permutation.
struct MarchingCase {
  std::uint8_t positives = 0;
  bool is_odd = false;
  std::array<std::uint8_t, 4> order{};
};

[[nodiscard]] constexpr std::array<MarchingCase, 16> make_marching_cases() {
  std::array<MarchingCase, 16> cases{};
  for (unsigned signs = 0; signs < 16; ++signs) {
    MarchingCase& c = cases[signs];
    std::size_t last = 4;
    for (std::uint8_t i = 0; i < 4; ++i) {
      if ((signs >> i & 1U) != 0) {
        c.order[c.positives++] = i;
      } else {
        c.order[--last] = i;
      }
    }
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = i + 1; j < 4; ++j) c.is_odd ^= c.order[i] > c.order[j];
    }
  }
  return cases;
}

// Indexed by the signs: bit i is set when corner i is positive.
inline constexpr std::array<MarchingCase, 16> kMarchingCases = make_marching_cases();

// The quad p, q, r, s in cyclic order, cut along its shorter diagonal; among equals along the one
// with the least end.
[[nodiscard]] inline TetrahedronSurface cut_quad(LatticePoint p, LatticePoint q, LatticePoint r,
                                                 LatticePoint s) {
  const auto squared_distance = [](LatticePoint a, LatticePoint b) {
    const auto square = [](std::int32_t d) { return std::int64_t{d} * d; };
    return square(a.x - b.x) + square(a.y - b.y) + square(a.z - b.z);
  };
  const std::int64_t pr = squared_distance(p, r);
  const std::int64_t qs = squared_distance(q, s);
  const bool along_pr = pr < qs || (pr == qs && std::min(p, r) < std::min(q, s));
  if (along_pr)
    return {.triangles = {LatticeTriangle{p, q, r}, LatticeTriangle{p, r, s}}, .count = 2};
  return {.triangles = {LatticeTriangle{q, r, s}, LatticeTriangle{q, s, p}}, .count = 2};
}

// The surface in a tetrahedron. `vertex(i, j)` is the vertex on the edge between corners i and j;
// `is_negative` whether the corners 0, 1, 2, 3 span a negative volume. Requires corners on both
// sides.
template <typename Vertex>
[[nodiscard]] TetrahedronSurface march(const MarchingCase& c, bool is_negative,
                                       const Vertex& vertex) {
  const bool turned = is_negative != c.is_odd;
  const auto at = [&](std::size_t i, std::size_t j) { return vertex(c.order[i], c.order[j]); };
  if (c.positives == 2) {
    const LatticePoint p = at(0, 2);
    const LatticePoint q = at(0, 3);
    const LatticePoint r = at(1, 3);
    const LatticePoint s = at(1, 2);
    return turned ? cut_quad(p, s, r, q) : cut_quad(p, q, r, s);
  }
  TetrahedronSurface result{.triangles = {}, .count = 1};
  if (c.positives == 1) {  // The triangle turns its back on corner 0.
    result.triangles[0] = {at(0, 1), at(0, 2), at(0, 3)};
  } else {  // The triangle faces corner 3.
    result.triangles[0] = {at(3, 0), at(3, 1), at(3, 2)};
  }
  if (turned) std::swap(result.triangles[0][1], result.triangles[0][2]);
  return result;
}

// The vertex on the edge from g to h, values on different sides of the isovalue c. The edge runs
// along an axis, a face diagonal or a cube diagonal, so it has L equal steps u, and the vertex sits
// at g + q delta u with q = round(t L / delta) clamped to [1, L / delta - 1]: exactly on the edge
// and never at its ends. The same for (g, h) and (h, g), bit for bit.
[[nodiscard]] inline LatticePoint lattice_vertex(GridPoint g, double value_g, GridPoint h,
                                                 double value_h, double c, int resolution) {
  if (h < g) {
    std::swap(g, h);
    std::swap(value_g, value_h);
  }
  const GridPoint edge = h - g;
  const std::int32_t length = std::max({std::abs(edge.x), std::abs(edge.y), std::abs(edge.z)});
  const std::int32_t steps = length << resolution;
  const double t = (c - value_g) / (value_h - value_g);
  // As floor: what is below 1 is clamped.
  const auto nearest = static_cast<std::int32_t>(t * steps + 0.5);
  const std::int32_t q = std::clamp(nearest, 1, steps - 1);
  const auto along = [&](std::int32_t from, std::int32_t extent) {
    const std::int32_t direction = (extent > 0 ? 1 : 0) - (extent < 0 ? 1 : 0);
    return (from << resolution) + direction * q;
  };
  return {along(g.x, edge.x), along(g.y, edge.y), along(g.z, edge.z)};
}

// Triangles face the low values. Values that are NaN are void.
[[nodiscard]] TetrahedronSurface marching_tetrahedron(const std::array<GridPoint, 4>& corners,
                                                      const std::array<float, 4>& values,
                                                      double isovalue, int resolution);

}  // namespace multitetra
