// Access to the samples of cells of a prepared volume, across its bricks.
#pragma once

#include <cstddef>
#include <vector>

#include "server/core/framework/grid.hpp"
#include "server/core/spectrum/prepared_volume.hpp"

namespace multitetra {

// Reads the samples of cells. Reads each brick once and keeps it: a brick contains eight cells or
// more, and reading it checks its file. Not thread-safe.
class CellSamples {
 public:
  // Serves the cells from the point `low` to the point `high`. The volume must outlive the reader.
  CellSamples(const PreparedVolume& volume, GridPoint low, GridPoint high);

  // Writes the values of the eight points along each axis from `low` on, including those beyond the
  // data, x fastest, with the strides `row` and `slice`. Requires multiples of kSpectrumSpacing,
  // inside the grid or below it.
  void load_cell(GridPoint low, float* into, std::ptrdiff_t row, std::ptrdiff_t slice);

 private:
  // Returns the samples of a brick, given its position among the bricks.
  [[nodiscard]] const std::byte* brick(GridPoint at);

  const PreparedVolume& volume_;
  const BrickLayout layout_;
  GridPoint first_;       // The brick that contains `low`.
  std::int32_t row_ = 0;  // Strides of bricks_.
  std::int32_t slice_ = 0;
  // Empty until first read.
  std::vector<RetainedBytes> bricks_;
};

}  // namespace multitetra
