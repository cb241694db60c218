// The isosurface of a model, cut into tiles.
//
// A tile is the surface in one octree cube without that of the tiles inside the cube: tetrahedra
// larger than a tile's cube belong to the tile of an enclosing one. Tiles are cut bottom-up: when a
// cube contains more than `max_triangles`, its children with most triangles become tiles of their
// own until the rest fits. The result depends only on the model, the field and the isovalue.
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
  // Maximum triangles of a tile; exceeded only if one octree cube of side 2 contains more.
  std::size_t max_triangles = 16000;
};

// Working memory, about 40 MB for the largest cubes plus the largest mesh in one of them; reuse it.
// Its contents between uses are meaningless.
struct CubeMemory {
  FineArrays fine;
  EdgeVertices vertices;
  LatticeMesh mesh;
};

// Returns the surface in a refined cube (see leaves.hpp).
[[nodiscard]] CubeSurface surface_in_cube(const Model& model, const Field& field,
                                          const OctreeCube& cube, const SurfaceOptions& options);

// Returns the same from the surfaces of the cube's children, computed separately: `children` is
// ordered by child index, with an empty CubeSurface for each child that is not refined.
[[nodiscard]] CubeSurface join_children(const Model& model, const Field& field,
                                        const OctreeCube& cube, std::vector<CubeSurface> children,
                                        const SurfaceOptions& options);

// Return the same for a prepared volume. `cube` must have an exponent of at least kSpectrumExponent
// and, for surface_in_cube, at most FineErrors::kMaxExponent.
[[nodiscard]] CubeSurface surface_in_cube(const PreparedModel& model, const OctreeCube& cube,
                                          const SurfaceOptions& options, CubeMemory& memory);
[[nodiscard]] CubeSurface join_children(const PreparedModel& model, const OctreeCube& cube,
                                        std::vector<CubeSurface> children,
                                        const SurfaceOptions& options);
// Returns whether the cube has tetrahedra of its own. Requires an exponent of at least
// kSpectrumExponent + 1.
[[nodiscard]] bool is_refined(const PreparedModel& model, const OctreeCube& cube);

// Returns all tiles; the rest at the root becomes the last one.
[[nodiscard]] std::vector<TileMesh> finished_tiles(CubeSurface root, const OctreeCube& root_cube);

}  // namespace multitetra
