// The samples of one cell of a prepared volume, wherever its bricks have them.
#pragma once

#include <cstddef>

#include "server/core/framework/grid.hpp"
#include "server/core/spectrum/prepared_volume.hpp"

namespace multitetra {

// Writes the values of the eight points along each axis from `low` on, those beyond the data
// included, x fastest, with the strides `row` and `slice`. Requires a place in the grid or before
// it, at multiples of kSpectrumSpacing.
void load_cell(const PreparedVolume& volume, GridPoint low, float* into, std::ptrdiff_t row,
               std::ptrdiff_t slice);

}  // namespace multitetra
