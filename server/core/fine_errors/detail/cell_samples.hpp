// The samples in cells of a prepared volume, wherever its bricks have them.
#pragma once

#include <cstddef>
#include <vector>

#include "server/core/framework/grid.hpp"
#include "server/core/spectrum/prepared_volume.hpp"

namespace multitetra {

// Reads the samples of cells. Each brick is read once and kept until the reader is destroyed: a
// brick holds eight cells or more, and reading one checks its file. Not thread-safe.
class CellSamples {
 public:
  // For cells from the point `low` to the point `high`. The volume must outlive it.
  CellSamples(const PreparedVolume& volume, GridPoint low, GridPoint high);

  // Writes the values of the eight points along each axis from `low` on, those beyond the data
  // included, x fastest, with the strides `row` and `slice`. Requires a place in the grid or before
  // it, at multiples of kSpectrumSpacing.
  void load_cell(GridPoint low, float* into, std::ptrdiff_t row, std::ptrdiff_t slice);

 private:
  // The samples of a brick, by its place among the bricks.
  [[nodiscard]] const std::byte* brick(GridPoint at);

  const PreparedVolume& volume_;
  const BrickLayout layout_;
  GridPoint first_;       // The brick that holds `low`.
  std::int32_t row_ = 0;  // Strides of bricks_.
  std::int32_t slice_ = 0;
  // Each is empty until it is first read.
  std::vector<RetainedBytes> bricks_;
};

}  // namespace multitetra
