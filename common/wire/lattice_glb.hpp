// A cell's surface as binary glTF with Draco (KHR_draco_mesh_compression).
//
// Positions are lattice coordinates of the whole grid, exactly, and every file has the same
// transform from there to grid coordinates, z up: so a vertex on the face between two cells is the
// same number in both and lands on the same place of the screen.
#pragma once

#include <string>

#include "common/mesh/mesh.hpp"
#include "common/mesh/octree_cube.hpp"

namespace multitetra {

// The mesh's normals, in grid coordinates, are in the file where it has some. An empty mesh gives a
// scene without a mesh; otherwise requires what encode_tile() requires of a mesh in that cube.
[[nodiscard]] std::string lattice_glb(const LatticeMesh& mesh, const OctreeCube& cube);

}  // namespace multitetra
