// The surface in the tetrahedra that lie in one octree cube but in none of its refined children,
// from the values at the cube's 27 points and a mask of the kept ones.
//
// Seen from the corner with even coordinates (in units of the cube's side), all cubes look the
// same: each face is cut from its corner next to the even one to the opposite corner. So one table
// of 84 tetrahedra serves all cubes, mirrored along axes whose even corner is the upper one.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "common/mesh/mesh.hpp"
#include "common/mesh/octree_cube.hpp"
#include "server/core/framework/grid.hpp"
#include "server/core/framework/rounding.hpp"
#include "server/core/surface/detail/edge_vertices.hpp"

namespace multitetra {

// The 27 points of a cube: index i + 3 j + 9 k is the center + step * turned (i - 1, j - 1, k - 1).
struct OctreeCubePoints {
  GridPoint center;
  std::int32_t step = 1;                           // Half the cube's side.
  std::array<std::int32_t, 3> turned = {1, 1, 1};  // -1 along axes where the even corner is upper.
  std::array<float, 27> values{};                  // NaN is void.
  // Bits of kept face centers and edge midpoints, and of corners whose child is refined.
  std::uint32_t kept = 0;

  [[nodiscard]] GridPoint at(std::size_t index) const { return center + turn(kOffsets[index]); }
  // Returns the sum of the ends of the edge between two points.
  [[nodiscard]] GridPoint sum_of_ends(std::size_t i, std::size_t j) const {
    return 2 * center + turn(kOffsets[i] + kOffsets[j]);
  }

 private:
  [[nodiscard]] GridPoint turn(GridPoint offset) const {
    return {step * turned[0] * offset.x, step * turned[1] * offset.y, step * turned[2] * offset.z};
  }
  static constexpr std::array<GridPoint, 27> kOffsets = [] {
    std::array<GridPoint, 27> offsets{};
    for (std::int32_t i = 0; i < 27; ++i) {
      offsets[static_cast<std::size_t>(i)] = {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
    }
    return offsets;
  }();
};

// Sets center, step and turns. Requires exponent >= 1.
[[nodiscard]] OctreeCubePoints points_of(const OctreeCube& cube);

// Returns the index of the corner of child `index` (see OctreeCube::child).
[[nodiscard]] inline std::size_t corner_of_child(const OctreeCubePoints& points, int index) {
  std::size_t corner = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const bool upper = (index >> axis & 1) != 0;
    const bool far = upper == (points.turned[static_cast<std::size_t>(axis)] > 0);
    constexpr std::array<std::size_t, 3> kStride = {1, 3, 9};
    corner += far ? 2 * kStride[static_cast<std::size_t>(axis)] : 0;
  }
  return corner;
}

// Extracts the surfaces of cubes into one mesh.
class OctreeCubeSurface {
 public:
  OctreeCubeSurface(double isovalue, int lattice_resolution)
      : isovalue_(isovalue),
        isovalue_below_(rounded_down(isovalue)),
        resolution_(lattice_resolution) {}

  struct Counts {
    std::uint32_t tetrahedra = 0;
    std::uint32_t active_tetrahedra = 0;
  };
  // Appends the triangles of the cube's own tetrahedra to the mesh; `known` indexes its vertices.
  Counts append(const OctreeCubePoints& points, EdgeVertices& known, LatticeMesh& mesh) const;

 private:
  double isovalue_;
  // A float exceeds the isovalue exactly if it exceeds this.
  float isovalue_below_;
  int resolution_;
};

}  // namespace multitetra
