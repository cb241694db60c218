// Small closed surfaces cut into tiles, for tests of the transfer of tiles.
#pragma once

#include <vector>

#include "common/dataset/dataset_info.hpp"
#include "common/wire/tile.hpp"

namespace multitetra::testing {

inline constexpr int kResolution = kDefaultLatticeResolution;

// Describes a nonexistent dataset of 33^3 samples.
inline DatasetInfo octahedra_info(std::string name = "octahedra") {
  DatasetInfo info;
  info.name = std::move(name);
  info.dims = {33, 33, 33};
  info.max = 255;
  info.grid_exponent = 5;
  info.suggested_isovalues = {100.5};
  return info;
}

// Returns the half of an octahedron on one side (-1 or 1) of the plane x = 16, the border of two
// cubes of side 16. Faces point outwards; both halves weld to a closed surface.
inline std::vector<LatticeTriangle> half_octahedron(std::int32_t side,
                                                    int resolution = kResolution) {
  const std::int32_t step = 1 << resolution;
  const LatticePoint center = {16 * step, 8 * step, 8 * step};
  const std::int32_t radius = 4 * step;
  std::vector<LatticeTriangle> triangles;
  for (const std::int32_t y : {-1, 1}) {
    for (const std::int32_t z : {-1, 1}) {
      LatticeTriangle t = {center, center, center};
      t[0].x += side * radius;
      t[1].y += y * radius;
      t[2].z += z * radius;
      if (side * y * z < 0) std::swap(t[1], t[2]);
      triangles.push_back(t);
    }
  }
  return triangles;
}

// Returns the same surface with its first triangle split in three at an inner point.
inline std::vector<LatticeTriangle> refined(std::vector<LatticeTriangle> triangles) {
  const LatticeTriangle t = triangles.front();
  const LatticePoint inner = {(t[0].x + t[1].x + t[2].x) / 3, (t[0].y + t[1].y + t[2].y) / 3,
                              (t[0].z + t[1].z + t[2].z) / 3};
  triangles.front() = {t[0], t[1], inner};
  triangles.push_back({t[1], t[2], inner});
  triangles.push_back({t[2], t[0], inner});
  return triangles;
}

// The cube that contains the half on that side.
inline OctreeCube cube_of_half(std::int32_t side) {
  return {.exponent = 4, .x = side < 0 ? 0 : 1, .y = 0, .z = 0};
}

inline EncodedTile tile_of(const std::vector<LatticeTriangle>& triangles, const OctreeCube& cube,
                           int resolution = kResolution) {
  return encode_tile(index_triangles(triangles, resolution), cube);
}

// An octahedron in two tiles, and the same with the right one refined.
inline std::vector<EncodedTile> coarse_tiles(int resolution = kResolution) {
  return {tile_of(half_octahedron(-1, resolution), cube_of_half(-1), resolution),
          tile_of(half_octahedron(1, resolution), cube_of_half(1), resolution)};
}
inline std::vector<EncodedTile> fine_tiles(int resolution = kResolution) {
  return {tile_of(half_octahedron(-1, resolution), cube_of_half(-1), resolution),
          tile_of(refined(half_octahedron(1, resolution)), cube_of_half(1), resolution)};
}

}  // namespace multitetra::testing
