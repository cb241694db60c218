// Meshes on integers as Draco bytes for the formats of others.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/mesh/mesh.hpp"
#include "common/mesh/octree_cube.hpp"

namespace multitetra {

// The fields of a glTF primitive with Draco compression.
struct DracoPrimitive {
  std::string bytes;
  // As a decoder finds them: vertices that Draco splits count as several.
  std::uint32_t points = 0;
  std::uint32_t triangles = 0;
  std::uint32_t position_id = 0;
  std::uint32_t normal_id = 1;  // Where the mesh has normals.
};

// With positions as floats that are the lattice coordinates exactly: quantized with a step of one,
// so that the same vertex is the same in every cell. Requires what encode_tile() requires of a mesh
// in that cube.
[[nodiscard]] DracoPrimitive encode_draco_primitive(const LatticeMesh& mesh,
                                                    const OctreeCube& cube);

// With positions as integers, not quantized, and nothing else: none of them negative. Requires 1 to
// kMaxTileTriangles triangles of three different vertices each.
[[nodiscard]] std::string encode_draco_integers(
    const std::vector<std::array<std::int32_t, 3>>& positions,
    const std::vector<TriangleIndices>& triangles);

}  // namespace multitetra
