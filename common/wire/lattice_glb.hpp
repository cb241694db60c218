// A cell's surface as binary glTF with Draco (KHR_draco_mesh_compression).
//
// Positions are lattice coordinates of the whole grid, exactly, and every file of one resolution
// has the same transform, which only makes lengths of them: so a vertex on the face between two
// cells is the same number in both and lands on the same place of the screen.
#pragma once

#include <string>

#include "common/base/affine.hpp"
#include "common/mesh/mesh.hpp"
#include "common/mesh/octree_cube.hpp"

namespace multitetra {

// `grid_step` is the length of a step of the grid along each axis, z up. The mesh's normals, of
// grid coordinates, are in the file where it has some. An empty mesh gives a scene without a mesh;
// otherwise requires what encode_tile() requires of a mesh in that cube.
[[nodiscard]] std::string lattice_glb(const LatticeMesh& mesh, const OctreeCube& cube,
                                      const Vec3& grid_step);

}  // namespace multitetra
