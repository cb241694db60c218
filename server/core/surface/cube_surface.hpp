// The surface in one octree cube, and how tiles are cut off from it while it grows.
//
// Wherever more than `max_triangles` come together in a cube, its children with most triangles
// become tiles of their own until the rest fits. Every tile has its vertices in the order in which
// its triangles first use them, whatever cubes it was put together from.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/mesh/mesh.hpp"
#include "common/mesh/octree_cube.hpp"
#include "common/mesh/vertex_numbers.hpp"

namespace multitetra {

struct TileMesh {
  OctreeCube cube;
  LatticeMesh mesh;                 // At least one triangle.
  double simplification_bound = 0;  // World units; 0 where it was not simplified.
};

// The surface in one octree cube, as far as it was cut off already.
struct CubeSurface {
  // Tetrahedra of the model in the cube.
  std::uint64_t tetrahedra = 0;
  // Those that the surface crosses.
  std::uint64_t active_tetrahedra = 0;
  std::vector<TileMesh> tiles;  // Cut off, smaller cubes first.
  LatticeMesh rest;             // Not yet in a tile. Vertices in any order, all used.
};

// Some triangles of a mesh with the vertices that they use, in the order of their first use.
// `number_of` is memory to work in, which is empty or comes from such a call for the same mesh.
[[nodiscard]] LatticeMesh part_of(const LatticeMesh& mesh, std::size_t begin, std::size_t end,
                                  std::vector<std::uint32_t>& number_of);

// The beginnings of the triangles of a cube's eight children, in the order of the child index, and
// the end of the last.
using ChildRanges = std::array<std::size_t, 9>;

class CubeSurfaceBuilder {
 public:
  // `mesh` is memory to work in: what it holds before and after means nothing.
  CubeSurfaceBuilder(int lattice_resolution, std::size_t max_triangles, LatticeMesh& mesh)
      : max_(max_triangles), mesh_(mesh) {
    mesh_.resolution = lattice_resolution;
    mesh_.vertices.clear();
    mesh_.triangles.clear();
  }

  // What is there and not yet cut off. Triangles are appended in the order of the cubes they lie
  // in: those of a cube stay together, its children's first.
  [[nodiscard]] LatticeMesh& mesh() { return mesh_; }
  [[nodiscard]] std::size_t triangles() const { return mesh_.triangles.size(); }
  void count(std::uint64_t tetrahedra, std::uint64_t active) {
    surface_.tetrahedra += tetrahedra;
    surface_.active_tetrahedra += active;
  }

  // Appends what was built apart: the surface in a child, or in no single one of them. Vertices
  // are shared with all that was appended so.
  void append(CubeSurface child, const OctreeCube& cube);
  void append(const LatticeMesh& mesh);

  // Makes tiles of the cube's children, from the triangle `begin` on, until the rest fits into one.
  void cut_off(const OctreeCube& cube, std::size_t begin, const ChildRanges& ranges);

  [[nodiscard]] CubeSurface take();

 private:
  template <typename IsShared>
  void weld(const LatticeMesh& mesh, const IsShared& is_shared);

  std::size_t max_;
  LatticeMesh& mesh_;
  CubeSurface surface_;
  VertexNumbers shared_;                  // Numbers of vertices that may be shared.
  std::vector<std::uint32_t> number_of_;  // For part_of.
};

}  // namespace multitetra
