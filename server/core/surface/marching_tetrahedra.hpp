// The isosurface inside one tetrahedron (marching tetrahedra), with vertices on the lattice.
//
// A corner is positive if its value is greater than the isovalue. One corner against three gives a
// triangle; two against two give a quad, which is cut along its shorter diagonal. There are no
// ambiguous cases, and two neighbours have the same intersection with their common face. A
// tetrahedron with a void corner has no surface.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <utility>

#include "common/mesh/mesh.hpp"
#include "server/core/framework/grid.hpp"

namespace multitetra {

struct TetrahedronSurface {
  std::array<LatticeTriangle, 2> triangles;
  std::size_t count = 0;  // 0, 1 or 2
};

// The edges of a tetrahedron, as pairs of its corners.
inline constexpr std::array<std::array<std::uint8_t, 2>, 6> kTetrahedronEdges = {
    {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

// The surface polygon for given signs of a tetrahedron's corners: the edges that its corners lie
// on, in an order that makes it face the negative corners.
struct MarchingCase {
  std::uint8_t corners = 0;  // 0, 3 or 4
  std::array<std::uint8_t, 4> edges{};
};

// Indexed by the signs (bit i is set if corner i is positive), and by whether the corners 0, 1, 2,
// 3 span a negative volume.
using MarchingCases = std::array<std::array<MarchingCase, 2>, 16>;

[[nodiscard]] constexpr MarchingCases make_marching_cases() {
  MarchingCases cases{};
  for (unsigned signs = 1; signs < 15; ++signs) {
    // Positive corners first; is_odd is the parity of this permutation.
    std::array<std::uint8_t, 4> order{};
    std::size_t positives = 0;
    std::size_t last = 4;
    for (std::uint8_t i = 0; i < 4; ++i) {
      ((signs >> i & 1U) != 0 ? order[positives++] : order[--last]) = i;
    }
    bool is_odd = false;
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = i + 1; j < 4; ++j) is_odd ^= order[i] > order[j];
    }
    const auto edge = [&](std::size_t i, std::size_t j) {
      const std::uint8_t low = std::min(order[i], order[j]);
      const std::uint8_t high = std::max(order[i], order[j]);
      return static_cast<std::uint8_t>(low + high - (low == 0 ? 1 : 0));
    };
    for (const bool is_negative : {false, true}) {
      MarchingCase& c = cases[signs][is_negative ? 1 : 0];
      const bool turned = is_negative != is_odd;
      if (positives == 2) {
        c = {.corners = 4, .edges = {edge(0, 2), edge(0, 3), edge(1, 3), edge(1, 2)}};
        if (turned) std::swap(c.edges[1], c.edges[3]);
      } else {
        // The triangle faces away from a single positive corner, or towards a single negative one.
        const std::size_t one = positives == 1 ? 0 : 3;
        c = {.corners = 3,
             .edges = {edge(one, one == 0 ? 1 : 0), edge(one, one == 0 ? 2 : 1),
                       edge(one, one == 0 ? 3 : 2)}};
        if (turned) std::swap(c.edges[1], c.edges[2]);
      }
    }
  }
  return cases;
}
inline constexpr MarchingCases kMarchingCases = make_marching_cases();

// Returns whether the quad p, q, r, s (in cyclic order) is cut along pr: its shorter diagonal or,
// of equal ones, that with the lesser end.
[[nodiscard]] inline bool is_cut_along_first(const LatticePoint& p, const LatticePoint& q,
                                             const LatticePoint& r, const LatticePoint& s) {
  const auto squared_distance = [](const LatticePoint& a, const LatticePoint& b) {
    const auto square = [](std::int32_t d) { return std::int64_t{d} * d; };
    return square(a.x - b.x) + square(a.y - b.y) + square(a.z - b.z);
  };
  const std::int64_t pr = squared_distance(p, r);
  const std::int64_t qs = squared_distance(q, s);
  return pr < qs || (pr == qs && std::min(p, r) < std::min(q, s));
}

// Returns the vertex on the edge from g to h, whose values lie on different sides of the isovalue
// c. The edge runs along an axis, a face diagonal or a cube diagonal, so it has L equal steps u,
// and the vertex is g + q delta u with q = round(t L / delta) clamped to [1, L / delta - 1]:
// exactly on the edge and never at its ends. The same for (g, h) and (h, g), bit for bit.
[[nodiscard]] inline LatticePoint lattice_vertex(GridPoint g, double value_g, GridPoint h,
                                                 double value_h, double c, int resolution) {
  // Starts from the lesser end. The extents of an edge are equal or 0 in magnitude, so the first
  // nonzero one decides.
  const GridPoint extents = h - g;
  const bool from_h = 4 * extents.x + 2 * extents.y + extents.z < 0;
  const std::array<double, 2> values = {value_g, value_h};
  const double first = values[from_h ? 1 : 0];
  const double last = values[from_h ? 0 : 1];
  const GridPoint from = from_h ? h : g;
  const std::int32_t side = from_h ? -1 : 1;
  const std::int32_t length =
      std::max({std::abs(extents.x), std::abs(extents.y), std::abs(extents.z)});
  const std::int32_t steps = length << resolution;
  const double t = (c - first) / (last - first);
  // Truncation serves as floor: results below 1 are clamped.
  const auto nearest = static_cast<std::int32_t>(t * steps + 0.5);
  const std::int32_t q = std::clamp(nearest, 1, steps - 1);
  const auto along = [&](std::int32_t start, std::int32_t extent) {
    const std::int32_t direction = (extent > 0 ? 1 : 0) - (extent < 0 ? 1 : 0);
    return (start << resolution) + side * direction * q;
  };
  return {along(from.x, extents.x), along(from.y, extents.y), along(from.z, extents.z)};
}

// Returns the triangles inside a tetrahedron; they face the low values. NaN values are void.
[[nodiscard]] TetrahedronSurface marching_tetrahedron(const std::array<GridPoint, 4>& corners,
                                                      const std::array<float, 4>& values,
                                                      double isovalue, int resolution);

}  // namespace multitetra
