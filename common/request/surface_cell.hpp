// The part of a surface in one octree cube, which can be requested separately.
//
// The model is refined until every tetrahedron lies in one cube of that size, and edges on the
// cube's faces stay as the model has them. So cells of one size fit together: their surfaces share
// only vertices on the faces, which are the same lattice points on both sides, and together they
// form the whole surface. A cell's surface depends only on the dataset and the request.
#pragma once

#include <cstdint>

#include "common/base/result.hpp"
#include "common/dataset/dataset_info.hpp"
#include "common/mesh/octree_cube.hpp"

namespace multitetra {

struct OctreeNode {
  OctreeCube cube = {};
  // The finest spacing of the hierarchy, as in a preview: grid steps, a power of two, at most half
  // the cube's side. 1 is that of the samples.
  std::int32_t finest_spacing = 1;

  friend bool operator==(const OctreeNode&, const OctreeNode&) = default;
};

// Cubes have at least 2^4 grid steps per side, or are the whole grid.
inline constexpr std::int32_t kMinCellExponent = 4;

// Fails with kInvalidArgument, naming the valid range, unless the cell is valid in some grid.
[[nodiscard]] Result<void> check_cell(const OctreeNode& cell);
// Fails likewise, and also if the cell is outside the dataset's grid or too small for it. Requires
// a valid cell.
[[nodiscard]] Result<void> check_cell(const OctreeNode& cell, const DatasetInfo& info);

}  // namespace multitetra
