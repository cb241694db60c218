// A part of a surface that can be requested by itself: the one in an octree cube.
//
// The model is refined until every tetrahedron lies in one cube of that size, and edges on the
// cube's faces stay as the model has them. So the cells of one size fit together: their surfaces
// share only vertices on the faces, which are the same lattice points on both sides, and together
// they are the whole surface. A cell's surface is a function of the dataset and the request alone,
// independent of other requests.
#pragma once

#include <cstdint>

#include "common/base/result.hpp"
#include "common/mesh/octree_cube.hpp"
#include "common/request/dataset_info.hpp"

namespace multitetra {

struct SurfaceCell {
  OctreeCube cube = {};
  // Where the hierarchy ends, as in a preview: grid steps, a power of two, at most half the cube's
  // side. 1: at the samples.
  std::int32_t finest_spacing = 1;

  friend bool operator==(const SurfaceCell&, const SurfaceCell&) = default;
};

// Cubes have 2^4 grid steps a side or more, or are the whole grid.
inline constexpr std::int32_t kMinCellExponent = 4;

// kInvalidArgument, saying what would be right, unless it can be a cell of some grid.
[[nodiscard]] Result<void> check_cell(const SurfaceCell& cell);
// The same unless the cell, which is valid, lies in the dataset's grid and is large enough there.
[[nodiscard]] Result<void> check_cell(const SurfaceCell& cell, const DatasetInfo& info);

}  // namespace multitetra
