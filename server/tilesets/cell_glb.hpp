// The glTF content of a cell's tile.
#pragma once

#include <string>

#include "common/dataset/dataset_info.hpp"
#include "common/mesh/mesh.hpp"
#include "common/mesh/octree_cube.hpp"
#include "common/wire/lattice_glb.hpp"

namespace multitetra {

// Returns lattice_glb() in metres, with the dataset's surface_name(). The mesh's normals, if any,
// are in world space, as in tiles.
[[nodiscard]] std::string cell_glb(LatticeMesh mesh, const DatasetInfo& info,
                                   const OctreeCube& cell, CellCodec codec = CellCodec::kDraco);

}  // namespace multitetra
