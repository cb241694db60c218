// Tiles of a surface as one mesh, with its topology, on several threads.
//
// Where the tiles' cubes do not overlap, two tiles have in common only what lies on the faces of
// their cubes: vertices and edges elsewhere are numbered and counted tile by tile, and few are left
// to be looked up.
#pragma once

#include <cstddef>
#include <functional>
#include <span>

#include "common/mesh/mesh.hpp"
#include "common/mesh/mesh_checks.hpp"
#include "common/mesh/octree_cube.hpp"

namespace multitetra {

struct TileInCube {
  const LatticeMesh* mesh = nullptr;
  OctreeCube cube = {};  // All vertices of the mesh lie in it, closed.
};

struct JoinedTiles {
  LatticeMesh mesh;
  MeshTopology topology;
};

// Calls its second argument with 0 ... count - 1, on any threads.
using ForEachTile =
    std::function<void(std::size_t count, const std::function<void(std::size_t)>& body)>;

// The mesh that weld() makes of them, with vertices in another order, and its topology(). Requires
// cubes whose insides do not overlap, meshes of this resolution in which every vertex is used,
// once, without normals and scalars, and fewer than 2^32 triangles.
[[nodiscard]] JoinedTiles joined_tiles(std::span<const TileInCube> tiles, int resolution,
                                       const DataBorder& border, const ForEachTile& for_each);

// Whether no two of the cubes overlap.
[[nodiscard]] bool are_apart(std::span<const OctreeCube> cubes);

}  // namespace multitetra
