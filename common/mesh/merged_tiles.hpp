// Tiles of a surface as one mesh, with its topology, on several threads.
//
// Where the tiles' cubes do not overlap, two tiles have in common only what lies on the faces of
// their cubes: vertices and edges elsewhere are numbered and counted tile by tile, and few are left
// to be looked up. Of a mesh that was marched here, the edges inside of its box are not even
// compared.
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
  OctreeCube cube = {};  // All vertices of the mesh lie in it, closed.
  // Set only where this process has made the mesh by marching the tetrahedra of all cells of the
  // box, whatever the signs and the values at their corners were. Such a mesh is manifold:
  //  * A crossed edge has one vertex, strictly inside of it, so different edges have different ones
  //    and no triangle is degenerate.
  //  * An edge of a triangle runs between two edges of one tetrahedron. If these meet, it lies in
  //    the one face that has both, and each of the two tetrahedra at that face has that edge once,
  //    as the face's three signs determine it, in opposite directions; a face of the box has one
  //    tetrahedron. If they do not meet, it is the diagonal of a quad, which both its triangles use.
  //  * A face of a tetrahedron lies in a face of the box exactly if all its edges do, and an edge
  //    does if its vertex does.
  // So an edge of a triangle is used once if both its ends lie in one face of the box, else twice.
  std::optional<MarchedBox> marched = {};
};

struct MergedTiles {
  LatticeMesh mesh;
  MeshTopology topology;
};

// Calls its second argument with 0 ... count - 1, on any threads.
using ForEachTile =
    std::function<void(std::size_t count, const std::function<void(std::size_t)>& body)>;

// The mesh that weld() makes of them, with vertices in another order, and its topology(). Requires
// cubes whose insides do not overlap, meshes of this resolution in which every vertex is used,
// once, without normals and scalars, and fewer than 2^32 triangles. The edges where tiles meet are
// always compared, as are those of a mesh that is not marked as marched.
[[nodiscard]] MergedTiles merged_tiles(std::span<const TileInCube> tiles, int resolution,
                                       const DataBorder& border, const ForEachTile& for_each);

// Whether no two of the cubes overlap.
[[nodiscard]] bool are_apart(std::span<const OctreeCube> cubes);

}  // namespace multitetra
