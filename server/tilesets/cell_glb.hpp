// A cell's surface as the content of its tile.
#pragma once

#include <string>

#include "common/mesh/mesh.hpp"
#include "common/mesh/octree_cube.hpp"
#include "common/request/dataset_info.hpp"

namespace multitetra {

// lattice_glb() in metres. The mesh's normals, if it has some, are of the world, as tiles have
// them.
[[nodiscard]] std::string cell_glb(LatticeMesh mesh, const DatasetInfo& info,
                                   const OctreeCube& cell);

}  // namespace multitetra
