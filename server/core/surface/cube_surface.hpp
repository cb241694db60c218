// The surface in one octree cube, from which tiles are cut off while it grows.
//
// When a cube contains more than `max_triangles`, its children with most triangles become tiles of
// their own until the rest fits. The vertices of a tile are in the order in which its triangles
// first use them, whichever cubes it was assembled from.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/mesh/mesh.hpp"
#include "common/mesh/octree_cube.hpp"
#include "common/mesh/vertex_numbers.hpp"

namespace multitetra {

struct TileMesh {
  OctreeCube cube;
  LatticeMesh mesh;                 // At least one triangle.
  double simplification_bound = 0;  // World units; 0 if not simplified.
};

// Returns one mesh of all tiles, in which equal vertices of different tiles are one vertex.
[[nodiscard]] LatticeMesh weld(std::span<const TileMesh> tiles, int resolution);

// The surface in one octree cube: tiles already cut off, and the rest.
struct CubeSurface {
  // Tetrahedra of the model in the cube.
  std::uint64_t tetrahedra = 0;
  // Tetrahedra that the surface crosses.
  std::uint64_t active_tetrahedra = 0;
  std::vector<TileMesh> tiles;  // Smaller cubes first.
  LatticeMesh rest;             // Triangles not yet in a tile; vertices in any order, all used.
};

// Returns the triangles [begin, end) of a mesh with their vertices, in the order of first use.
// `number_of` is working memory, either empty or left by a previous call for the same mesh.
[[nodiscard]] LatticeMesh part_of(const LatticeMesh& mesh, std::size_t begin, std::size_t end,
                                  std::vector<std::uint32_t>& number_of);

// The first triangle of each of a cube's eight children, by child index, and the end of the last.
using ChildRanges = std::array<std::size_t, 9>;

class CubeSurfaceBuilder {
 public:
  // `mesh` is working memory; its contents before and after are meaningless.
  CubeSurfaceBuilder(int lattice_resolution, std::size_t max_triangles, LatticeMesh& mesh)
      : max_(max_triangles), mesh_(mesh) {
    mesh_.resolution = lattice_resolution;
    mesh_.vertices.clear();
    mesh_.triangles.clear();
  }

  // Returns the triangles not yet cut off. Further ones must be appended by cube, with those of a
  // cube contiguous and its children's first.
  [[nodiscard]] LatticeMesh& mesh() { return mesh_; }
  [[nodiscard]] std::size_t triangles() const { return mesh_.triangles.size(); }
  void count(std::uint64_t tetrahedra, std::uint64_t active) {
    surface_.tetrahedra += tetrahedra;
    surface_.active_tetrahedra += active;
  }

  // Append a separately built surface: that of a child, or one not in a single child. Vertices are
  // shared among all surfaces appended this way.
  void append(CubeSurface child, const OctreeCube& cube);
  void append(const LatticeMesh& mesh);

  // Turns children of the cube into tiles until its triangles, from `begin` on, fit into one.
  void cut_off(const OctreeCube& cube, std::size_t begin, const ChildRanges& ranges);

  [[nodiscard]] CubeSurface take();

 private:
  template <typename IsShared>
  void weld(const LatticeMesh& mesh, const IsShared& is_shared);

  std::size_t max_;
  LatticeMesh& mesh_;
  CubeSurface surface_;
  VertexNumbers shared_;                  // Numbers of vertices that may be shared.
  std::vector<std::uint32_t> number_of_;  // Working memory of part_of.
};

}  // namespace multitetra
