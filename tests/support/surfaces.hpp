// Small surfaces on the lattice, constructed without a volume, for tests of the transfer of meshes.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "common/mesh/mesh.hpp"
#include "common/mesh/octree_cube.hpp"

namespace multitetra::surfaces {

// The cube of the grid that contains all these surfaces.
inline constexpr OctreeCube kCube{.exponent = 5, .x = 1, .y = 0, .z = 2};

inline LatticePoint low_corner(int resolution) {
  const std::int32_t side = kCube.side() << resolution;
  return {kCube.x * side, kCube.y * side, kCube.z * side};
}

inline bool is_degenerate(const LatticeTriangle& t) {
  return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

// A torus of 2 * around * across triangles whose vertices are moved at random by up to `noise` grid
// steps: closed, oriented, Euler characteristic 0. Omits triangles that rounding made degenerate,
// which at coarse resolutions opens it.
inline LatticeMesh torus(int resolution, int around, int across, double noise, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-noise, noise);
  const LatticePoint corner = low_corner(resolution);
  const double scale = std::ldexp(1.0, resolution);
  std::vector<LatticePoint> points;
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const double u = 2 * std::numbers::pi * i / around;
      const double v = 2 * std::numbers::pi * j / across;
      const double radius = 9.5 + 4 * std::cos(v);
      const auto lattice = [&](double grid, std::int32_t low) {
        return low + static_cast<std::int32_t>(std::lround((grid + shift(random)) * scale));
      };
      points.push_back({lattice(16 + radius * std::cos(u), corner.x),
                        lattice(16 + radius * std::sin(u), corner.y),
                        lattice(16 + 4 * std::sin(v), corner.z)});
    }
  }
  const auto point = [&](int i, int j) {
    return points[static_cast<std::size_t>(i % around * across + j % across)];
  };
  std::vector<LatticeTriangle> triangles;
  const auto add = [&triangles](const LatticeTriangle& t) {
    if (!is_degenerate(t)) triangles.push_back(t);
  };
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      add({point(i, j), point(i + 1, j), point(i + 1, j + 1)});
      add({point(i, j), point(i + 1, j + 1), point(i, j + 1)});
    }
  }
  return index_triangles(triangles, resolution);
}

// An octahedron of "radius" `steps` lattice steps around `center`: 8 triangles, 6 vertices, facing
// outwards.
inline std::vector<LatticeTriangle> octahedron(const LatticePoint& center, std::int32_t steps) {
  const auto tip = [&](std::int32_t x, std::int32_t y, std::int32_t z) {
    return LatticePoint{center.x + x * steps, center.y + y * steps, center.z + z * steps};
  };
  std::vector<LatticeTriangle> triangles;
  for (const std::int32_t x : {-1, 1}) {
    for (const std::int32_t y : {-1, 1}) {
      for (const std::int32_t z : {-1, 1}) {
        LatticeTriangle t = {tip(x, 0, 0), tip(0, y, 0), tip(0, 0, z)};
        if (x * y * z < 0) std::swap(t[1], t[2]);
        triangles.push_back(t);
      }
    }
  }
  return triangles;
}

inline LatticePoint center(int resolution) {
  const LatticePoint low = low_corner(resolution);
  const std::int32_t half = (kCube.side() << resolution) / 2;
  return {low.x + half, low.y + half, low.z + half};
}

// Two octahedra that touch in one vertex, where the surface has two fans, which Draco must split.
inline LatticeMesh touching_octahedra(int resolution) {
  const LatticePoint middle = center(resolution);
  std::vector<LatticeTriangle> triangles = octahedron({middle.x - 4, middle.y, middle.z}, 4);
  for (const LatticeTriangle& t : octahedron({middle.x + 4, middle.y, middle.z}, 4)) {
    triangles.push_back(t);
  }
  return index_triangles(triangles, resolution);
}

}  // namespace multitetra::surfaces
