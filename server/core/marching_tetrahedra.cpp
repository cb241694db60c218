#include "server/core/marching_tetrahedra.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <utility>

#include "server/core/field.hpp"

namespace multitetra {
namespace {

std::int64_t squared_distance(LatticePoint p, LatticePoint q) {
  const auto square = [](std::int32_t d) { return std::int64_t{d} * d; };
  return square(p.x - q.x) + square(p.y - q.y) + square(p.z - q.z);
}

// The quad p, q, r, s in cyclic order, cut along its shorter diagonal; among equals along the one
// with the least end.
TetrahedronSurface cut_quad(LatticePoint p, LatticePoint q, LatticePoint r, LatticePoint s) {
  const std::int64_t pr = squared_distance(p, r);
  const std::int64_t qs = squared_distance(q, s);
  const bool along_pr = pr < qs || (pr == qs && std::min(p, r) < std::min(q, s));
  TetrahedronSurface result{.triangles = {}, .count = 2};
  if (along_pr) {
    result.triangles = {LatticeTriangle{p, q, r}, LatticeTriangle{p, r, s}};
  } else {
    result.triangles = {LatticeTriangle{q, r, s}, LatticeTriangle{q, s, p}};
  }
  return result;
}

}  // namespace

LatticePoint lattice_vertex(GridPoint g, double value_g, GridPoint h, double value_h, double c,
                            int resolution) {
  if (h < g) {
    std::swap(g, h);
    std::swap(value_g, value_h);
  }
  const GridPoint edge = h - g;
  const std::int32_t length = std::max({std::abs(edge.x), std::abs(edge.y), std::abs(edge.z)});
  const std::int32_t steps = length << resolution;
  const double t = (c - value_g) / (value_h - value_g);
  const auto nearest = static_cast<std::int32_t>(std::floor(t * steps + 0.5));
  const std::int32_t q = std::clamp(nearest, 1, steps - 1);
  const auto along = [&](std::int32_t from, std::int32_t extent) {
    return (from << resolution) + extent / length * q;
  };
  return {along(g.x, edge.x), along(g.y, edge.y), along(g.z, edge.z)};
}

TetrahedronSurface marching_tetrahedron(const std::array<GridPoint, 4>& corners,
                                        const std::array<float, 4>& values, double isovalue,
                                        int resolution) {
  std::array<std::size_t, 4> order{};  // Positive corners first.
  std::size_t positives = 0;
  std::size_t negatives = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    if (is_void(values[i])) return {};
    if (static_cast<double>(values[i]) > isovalue) {
      order[positives++] = i;
    } else {
      order[3 - negatives++] = i;
    }
  }
  if (positives == 0 || negatives == 0) return {};

  const auto corner = [&](std::size_t i) { return corners[order[i]]; };
  const auto vertex = [&](std::size_t i, std::size_t j) {
    return lattice_vertex(corner(i), static_cast<double>(values[order[i]]), corner(j),
                          static_cast<double>(values[order[j]]), isovalue, resolution);
  };
  const bool turned = six_volumes(corner(0), corner(1), corner(2), corner(3)) < 0;
  if (positives == 2) {
    const LatticePoint p = vertex(0, 2);
    const LatticePoint q = vertex(0, 3);
    const LatticePoint r = vertex(1, 3);
    const LatticePoint s = vertex(1, 2);
    return turned ? cut_quad(p, s, r, q) : cut_quad(p, q, r, s);
  }
  TetrahedronSurface result{.triangles = {}, .count = 1};
  if (positives == 1) {  // The triangle turns its back on corner 0.
    result.triangles[0] = {vertex(0, 1), vertex(0, 2), vertex(0, 3)};
  } else {  // The triangle faces corner 3.
    result.triangles[0] = {vertex(3, 0), vertex(3, 1), vertex(3, 2)};
  }
  if (turned) std::swap(result.triangles[0][1], result.triangles[0][2]);
  return result;
}

}  // namespace multitetra
