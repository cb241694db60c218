// A cell's surface as binary glTF with Draco (KHR_draco_mesh_compression), or with meshoptimizer's
// codec (EXT_meshopt_compression), which decodes much faster.
//
// Positions are the exact lattice coordinates of the whole grid, and all files of one resolution
// have the same transform, which scales them to lengths. So a vertex on the face between two cells
// has the same numbers in both files and is drawn at the same place.
#pragma once

#include <string>

#include "common/base/affine.hpp"
#include "common/base/enum_names.hpp"
#include "common/dataset/surface_name.hpp"
#include "common/mesh/mesh.hpp"
#include "common/mesh/octree_cube.hpp"

namespace multitetra {

enum class CellCodec { kDraco, kMeshopt };
inline constexpr EnumNames<CellCodec, 2> kCellCodecs = {{"draco", "meshopt"}};

// `grid_step` is the length of a grid step along each axis, z up. Includes the mesh's normals,
// which must be in grid coordinates, if it has any. `name` is the node's, see name_node(). An empty
// mesh gives a scene without a mesh; otherwise has the requirements of encode_tile().
[[nodiscard]] std::string lattice_glb(const LatticeMesh& mesh, const OctreeCube& cube,
                                      const Vec3& grid_step, const SurfaceName& name = {},
                                      CellCodec codec = CellCodec::kDraco);

}  // namespace multitetra
