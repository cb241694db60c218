// Tetrahedra of the framework and their bisection (Zhou, Chen and Kaufman 1997, section 3).
//
// A tetrahedron is written kind[a,b | k,d]: the kind of its dividing point, its split edge ab, its
// other corners. A cube with center d starts as twelve tetrahedra: for each face, its diagonal ab
// with either of the face's other corners k. Then
//
//   face[a,b | k,d]   f = mid(a,b):   edge[a,k | f,d]   edge[b,k | f,d]
//   edge[a,k | f,d]   m = mid(a,k):   cube[a,d | m,f]   cube[k,d | m,f]
//   cube[a,d | m,f]   o = mid(a,d):   face[a,f | m,o]   face[d,m | f,o]
//
// until the split edge's largest coordinate extent is 1. After each cube step, twelve tetrahedra
// again fill an octree cube, so every tetrahedron lies in one octree cube of each size >= its own.
#pragma once

#include <array>
#include <cstdlib>

#include "common/mesh/octree_cube.hpp"
#include "server/core/framework/dividing_point.hpp"

namespace multitetra {

struct Tetrahedron {
  PointKind kind;
  GridPoint a;  // The split edge is ab.
  GridPoint b;
  GridPoint k;
  GridPoint d;

  // Returns whether the midpoint of the split edge is a grid point.
  [[nodiscard]] constexpr bool is_divisible() const {
    const GridPoint e = b - a;
    return ((e.x | e.y | e.z) & 1) == 0;
  }
  [[nodiscard]] constexpr DividingPoint dividing_point() const {
    return DividingPoint(midpoint(a, b));
  }
  [[nodiscard]] constexpr std::array<GridPoint, 4> corners() const { return {a, b, k, d}; }

  // Requires is_divisible().
  [[nodiscard]] constexpr std::array<Tetrahedron, 2> bisect() const {
    const GridPoint p = midpoint(a, b);
    switch (kind) {
      case PointKind::kFace:  // p is the paper's f
        return {Tetrahedron{PointKind::kEdge, a, k, p, d},
                Tetrahedron{PointKind::kEdge, b, k, p, d}};
      case PointKind::kEdge:  // [a,k | f,d], p = m
        return {Tetrahedron{PointKind::kCube, a, d, p, k},
                Tetrahedron{PointKind::kCube, b, d, p, k}};
      case PointKind::kCube:  // [a,d | m,f], p = o
        break;
    }
    return {Tetrahedron{PointKind::kFace, a, d, k, p}, Tetrahedron{PointKind::kFace, b, k, d, p}};
  }
};

// Returns the center of a cube with an even side: the cube point whose insertion fills it with
// twelve tetrahedra.
[[nodiscard]] constexpr DividingPoint center(const OctreeCube& cube) {
  const std::int32_t side = cube.side();
  const auto middle = [side](std::int32_t position) { return position * side + side / 2; };
  return DividingPoint({middle(cube.x), middle(cube.y), middle(cube.z)});
}

// Returns the twelve tetrahedra of a cube. Requires exponent >= 1.
[[nodiscard]] constexpr std::array<Tetrahedron, 12> tetrahedra_of(const OctreeCube& cube) {
  const GridPoint d = center(cube).at();
  const std::int32_t s = cube.side() / 2;
  std::array<Tetrahedron, 12> result{};
  std::size_t count = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (const std::int32_t sign : {-1, 1}) {
      const DividingPoint face(d + (sign * s) * unit(axis));
      const auto [a, b] = face.split_edge();
      const PointList<8> ring = face.ring();  // Elements 0 and 2 are the face's other corners.
      result[count++] = {PointKind::kFace, a, b, ring[0], d};
      result[count++] = {PointKind::kFace, a, b, ring[2], d};
    }
  }
  return result;
}

}  // namespace multitetra
