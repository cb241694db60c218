// The tetrahedra of a model as cells with values at their corners: what is written to a file for
// volume rendering.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "server/core/errors/error_based_model.hpp"
#include "server/core/framework/field.hpp"

namespace multitetra {

enum class ModelScope {
  kAll,      // The whole volume.
  kSurface,  // Only what the surface crosses.
};

struct ModelCells {
  std::vector<GridPoint> points;
  std::vector<float> values;  // The values at the points.
  // Corners as indices of points, the fourth on the side that the first three, turning
  // counter-clockwise, face.
  std::vector<std::array<std::int64_t, 4>> cells;
  std::vector<std::int32_t>
      // For each cell the largest extent of its tetrahedron in grid steps.
      sizes;
};

// The cells fill the data without gap or overlap where void lies around it, the whole grid where a
// value does, and the surface of `isovalue` in them is the model's. Grid and data seldom end
// together: a tetrahedron that reaches beyond the last samples is pushed back to them, corner by
// corner, which turns none over. A corner that was pushed has the value there or, if the surface
// would then cross the cell, one from the cell's own side.
//
// Left out is what has a void sample of the data (a mask) at a corner and, where a topology
// tolerance or a level lets the surface run into the void, cells with both sides in them: the
// surface is not drawn there either. Cells come in the order of visit_leaves().
[[nodiscard]] ModelCells model_cells(const Model& model, const Field& field, double isovalue,
                                     ModelScope scope);

}  // namespace multitetra
