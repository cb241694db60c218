// Merges the tiles of a surface into one mesh and computes its topology, on several threads.
//
// If no triangle of a tile is in the cube of another one, tiles share only vertices and edges on
// the faces of their cubes. All others are numbered and counted tile by tile, which leaves few to
// look up. For meshes marched by this process, edges inside their box are not even compared.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>

#include "common/mesh/mesh.hpp"
#include "common/mesh/mesh_checks.hpp"
#include "common/mesh/octree_cube.hpp"

namespace multitetra {

// The corners of a box of cells, in lattice coordinates.
struct MarchedBox {
  LatticePoint low;
  LatticePoint high;
};

struct TileInCube {
  const LatticeMesh* mesh = nullptr;
  // Contains all vertices of the mesh, faces included.
  OctreeCube cube = {};
  // Set only if this process made the mesh by marching the tetrahedra of all cells of the box, with
  // any signs and values at their corners. Such a mesh is manifold:
  //  * A crossed edge has one vertex, strictly inside it, so different edges have different
  //    vertices and no triangle is degenerate.
  //  * A triangle's edge connects two edges of one tetrahedron. If these meet, it lies in the face
  //    they span. The face's three signs determine it, so both tetrahedra at that face have it
  //    once, in opposite directions; a face of the box has one tetrahedron. If they do not meet, it
  //    is the diagonal of a quad, which both its triangles use.
  //  * A face of a tetrahedron lies in a face of the box if and only if all its edges do, and an
  //    edge does if its vertex does.
  // So a triangle's edge is used once if both its ends lie in one face of the box, otherwise twice.
  std::optional<MarchedBox> marched = {};
};

struct MergedTiles {
  LatticeMesh mesh;
  MeshTopology topology;
};

// Calls `body` with 0 ... count - 1, on any threads.
using ForEachTile =
    std::function<void(std::size_t count, const std::function<void(std::size_t)>& body)>;

// Returns the same mesh as weld(), except for the order of vertices, without normals and scalars,
// and its topology(). Requires meshes of this resolution in which every vertex is used and
// occurs once, and no triangle inside the cube of another tile; different cubes; fewer than 2^32
// triangles. Always compares edges at
// seams and edges of meshes not marked as marched.
[[nodiscard]] MergedTiles merged_tiles(std::span<const TileInCube> tiles, int resolution,
                                       const DataBorder& border, const ForEachTile& for_each);

// Returns whether the interiors of the cubes are disjoint.
[[nodiscard]] bool are_disjoint(std::span<const OctreeCube> cubes);

}  // namespace multitetra
