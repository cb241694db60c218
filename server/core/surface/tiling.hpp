// The isosurface of a model, cut into tiles.
//
// A tile is the surface in one octree cube, without that of the tiles inside the cube: tetrahedra
// that are larger than a tile's cube belong to the tile of an enclosing one. Tiles are cut
// bottom-up: wherever more than `max_triangles` come together in a cube, its children with most
// triangles become tiles of their own until the rest fits. The result is a function of the model,
// the field and the isovalue alone.
#pragma once

#include <cstdint>
#include <vector>

#include "common/mesh/octree_cube.hpp"
#include "server/core/errors/error_based_model.hpp"
#include "server/core/fine_errors/prepared_model.hpp"
#include "server/core/framework/field.hpp"
#include "server/core/surface/cube_surface.hpp"
#include "server/core/surface/detail/edge_vertices.hpp"

namespace multitetra {

struct SurfaceOptions {
  double isovalue = 0;
  int lattice_resolution = kDefaultLatticeResolution;
  // The most triangles of a tile, exceeded only where one octree cube of side 2 holds more.
  std::size_t max_triangles = 16000;
};

// Memory to work in, some 40 MB for the largest cubes and the largest mesh in one of them: worth to
// be used again. What it holds between two uses means nothing.
struct CubeMemory {
  FineArrays fine;
  EdgeVertices vertices;
  LatticeMesh mesh;
};

// The surface in a refined cube (see leaves.hpp).
[[nodiscard]] CubeSurface surface_in_cube(const Model& model, const Field& field,
                                          const OctreeCube& cube, const SurfaceOptions& options);

// The same, from the surfaces in the refined ones of its children, which were computed apart:
// `children` holds them in the order of the child index, with an empty CubeSurface for a child that
// is not refined.
[[nodiscard]] CubeSurface join_children(const Model& model, const Field& field,
                                        const OctreeCube& cube, std::vector<CubeSurface> children,
                                        const SurfaceOptions& options);

// The same two for a prepared volume. `cube` has an exponent of at least kSpectrumExponent;
// surface_in_cube takes at most FineErrors::kMaxExponent, and memory to work in.
[[nodiscard]] CubeSurface surface_in_cube(const PreparedModel& model, const OctreeCube& cube,
                                          const SurfaceOptions& options, CubeMemory& memory);
[[nodiscard]] CubeSurface join_children(const PreparedModel& model, const OctreeCube& cube,
                                        std::vector<CubeSurface> children,
                                        const SurfaceOptions& options);
// Whether the cube, whose exponent is at least kSpectrumExponent + 1, has tetrahedra of its own.
[[nodiscard]] bool is_refined(const PreparedModel& model, const OctreeCube& cube);

// The whole as tiles: what is left at the root becomes the last one.
[[nodiscard]] std::vector<TileMesh> finished_tiles(CubeSurface root, const OctreeCube& root_cube);

}  // namespace multitetra
