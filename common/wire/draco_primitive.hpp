// Encodes meshes with integer positions in Draco for the formats of other programs.
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
  // The numbers a decoder finds: vertices split by Draco count several times.
  std::uint32_t points = 0;
  std::uint32_t triangles = 0;
  std::uint32_t position_id = 0;
  std::uint32_t normal_id = 1;  // If the mesh has normals.
};

// Encodes positions as floats that equal the lattice coordinates exactly, quantized with a step of
// one, so a shared vertex is the same in every cell. Has the requirements of encode_tile().
[[nodiscard]] DracoPrimitive encode_draco_primitive(const LatticeMesh& mesh,
                                                    const OctreeCube& cube);

// Encodes positions as integers without quantization, and nothing else. Requires positions >= 0,
// and 1 to kMaxTileTriangles triangles, each with three different vertices.
[[nodiscard]] std::string encode_draco_integers(
    const std::vector<std::array<std::int32_t, 3>>& positions,
    const std::vector<TriangleIndices>& triangles);

}  // namespace multitetra
