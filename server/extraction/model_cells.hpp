// The tetrahedra of a model as cells with values at their corners, for files for volume rendering.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "server/core/errors/error_based_model.hpp"
#include "server/core/framework/field.hpp"

namespace multitetra {

enum class ModelScope {
  kAll,      // The whole volume.
  kSurface,  // Only cells that the surface crosses.
};

struct ModelCells {
  std::vector<GridPoint> points;
  std::vector<float> values;  // The values at the points.
  // Corners as indices of points. The first three, counter-clockwise, face the side of the fourth.
  std::vector<std::array<std::int64_t, 4>> cells;
  std::vector<std::int32_t> sizes;  // Largest extent of each cell's tetrahedron, in grid steps.
};

// Returns the cells of a model. They fill the data, or the whole grid if the field has a value
// outside, without gaps or overlaps, and the surface of `isovalue` in them is the model's. The grid
// usually extends beyond the data: if it is void there, corners of tetrahedra beyond the last
// samples are pushed back to them, which reverses no cell. A pushed corner has the value there or,
// if the surface would then cross the cell, one from the cell's own side.
//
// Cells with a void sample of the data (a mask) at a corner are omitted. So are pushed cells with
// both sides in them, which occur where a topology tolerance or a level lets the surface extend
// into the void: the surface is not drawn there either. Cells are in the order of visit_leaves().
[[nodiscard]] ModelCells model_cells(const Model& model, const Field& field, double isovalue,
                                     ModelScope scope);

}  // namespace multitetra
