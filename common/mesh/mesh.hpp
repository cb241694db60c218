// Triangle meshes on the lattice.
//
// A `LatticeMesh` has every vertex once: two corners with equal coordinates have the same index.
// Triangles face the side of low values (their normal, by the right-hand rule in grid coordinates,
// points from high values to low).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/affine.hpp"
#include "common/mesh/lattice.hpp"

namespace multitetra {

using LatticeTriangle = std::array<LatticePoint, 3>;
using TriangleIndices = std::array<std::uint32_t, 3>;
using UnitVector = std::array<float, 3>;

struct LatticeMesh {
  int resolution = kDefaultLatticeResolution;  // r: lattice steps per grid step are 2^r.
  std::vector<LatticePoint> vertices;
  std::vector<TriangleIndices> triangles;
  // Either none, or one a vertex: the directions in which the field falls, in world coordinates.
  std::vector<UnitVector> normals = {};
  // Either none, or one a vertex: values of a field that colors the surface; NaN for none.
  std::vector<float> scalars = {};
};

// The triangles with shared vertices; vertices are numbered in the order they first appear.
// Requires lattice coordinates within 0 .. 2^kMaxLatticeBits.
[[nodiscard]] LatticeMesh index_triangles(std::span<const LatticeTriangle> triangles,
                                          int resolution);

// The same mesh in the order that its triangles alone decide: vertices by their coordinates,
// triangles from their first vertex on and by their vertices. Encoding and decoding, which keeps no
// order, changes nothing of it.
[[nodiscard]] LatticeMesh in_canonical_order(const LatticeMesh& mesh);

// One mesh of several, of one resolution, welded by comparing integers. Vertices and triangles keep
// their order. It has normals or scalars when all meshes have; a vertex has those of the first mesh
// it is in.
[[nodiscard]] LatticeMesh weld(std::span<const LatticeMesh* const> meshes, int resolution);

// A mesh in world (or sample index) coordinates, for files and screens.
struct PositionedMesh {
  std::vector<std::array<float, 3>> positions;
  std::vector<TriangleIndices> triangles;
  std::vector<UnitVector> normals = {};  // Either none, or one a position.
  std::vector<float> scalars = {};       // The same; NaN for no value.
  // The same: red, green, blue in sRGB.
  std::vector<std::array<std::uint8_t, 3>> colors = {};
};

// Applies `grid_to_world`. Where that map mirrors, triangles are turned over so that they still
// face low values. Positions are rounded to float after the map was applied in double. Normals are
// copied: they are in world coordinates before and after. So are scalars.
[[nodiscard]] PositionedMesh positioned(const LatticeMesh& mesh, const Affine& grid_to_world);

// Whether the vector has length 1 up to rounding. False for NaN.
[[nodiscard]] bool is_unit(const UnitVector& v);

}  // namespace multitetra
