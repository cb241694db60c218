// Triangle meshes on the lattice.
//
// A `LatticeMesh` contains each vertex once: corners with equal coordinates have the same index.
// Triangles face low values (their normal, by the right-hand rule in grid coordinates, points from
// high values to low).
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "common/base/affine.hpp"
#include "common/mesh/lattice.hpp"

namespace multitetra {

using LatticeTriangle = std::array<LatticePoint, 3>;
using TriangleIndices = std::array<std::uint32_t, 3>;
using UnitVector = std::array<float, 3>;

struct LatticeMesh {
  int resolution = kDefaultLatticeResolution;  // r: there are 2^r lattice steps per grid step.
  std::vector<LatticePoint> vertices;
  std::vector<TriangleIndices> triangles;
  // Empty, or one per vertex: the direction of steepest descent of the field, in world coordinates.
  std::vector<UnitVector> normals = {};
  // Empty, or one per vertex: values of a field that colors the surface; NaN for none.
  std::vector<float> scalars = {};
};

// Returns the triangles with shared vertices, numbered in the order they first appear. Requires
// lattice coordinates within 0 .. 2^kMaxLatticeBits.
[[nodiscard]] LatticeMesh index_triangles(std::span<const LatticeTriangle> triangles,
                                          int resolution);

// Returns the mesh in an order that depends only on its triangles: vertices sorted by coordinates,
// triangles rotated to their first vertex and sorted. Encoding and decoding, which keep no order,
// do not affect it.
[[nodiscard]] LatticeMesh in_canonical_order(const LatticeMesh& mesh);

// Welds meshes of one resolution by comparing integers. Keeps the order of vertices and triangles.
// The result has normals or scalars if all meshes have them; a vertex takes those of the first mesh
// that contains it.
[[nodiscard]] LatticeMesh weld(std::span<const LatticeMesh* const> meshes, int resolution);
[[nodiscard]] LatticeMesh weld(std::span<const LatticeMesh> meshes, int resolution);

inline constexpr double kAnyRounding = std::numeric_limits<double>::infinity();

// A mesh in world (or sample index) coordinates, for files and display.
struct PositionedMesh {
  std::vector<Vec3> positions;
  std::vector<TriangleIndices> triangles;
  std::vector<UnitVector> normals = {};  // Empty, or one per position.
  std::vector<float> scalars = {};       // Empty, or one per position; NaN for no value.
  // Empty, or one per position: red, green, blue in sRGB.
  std::vector<std::array<std::uint8_t, 3>> colors = {};
  // How far files may move positions along each axis by rounding. Infinite: as far as floats do.
  Vec3 rounding_limits = {kAnyRounding, kAnyRounding, kAnyRounding};
};

// The fraction of a lattice step by which a file may move a vertex along any axis of the lattice.
inline constexpr double kMaxVertexRounding = 0.01;

// Applies `grid_to_world`. Reverses triangles if the map mirrors, so they still face low values.
// Copies normals, which are in world coordinates already, and scalars. The rounding limits are
// those of kMaxVertexRounding.
[[nodiscard]] PositionedMesh positioned(const LatticeMesh& mesh, const Affine& grid_to_world);

// Returns whether the vector has length 1 up to rounding. False for NaN.
[[nodiscard]] bool is_unit(const UnitVector& v);

}  // namespace multitetra
