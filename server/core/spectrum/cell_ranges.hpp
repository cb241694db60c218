// The least and the largest sample of every cell, so that queries find the cells that a surface may
// cross without reading samples.
#pragma once

#include <cstddef>
#include <cstdint>

#include "common/dataset/dataset_info.hpp"
#include "server/core/framework/for_each.hpp"
#include "server/core/framework/volume.hpp"
#include "server/core/spectrum/spectrum_inputs.hpp"

namespace multitetra {

// Collects the ranges of cell_extent(info) in one pass over a volume. Keeps a few layers of cells
// in memory and writes the others to the scratch.
class CellRanges {
 public:
  // The scratch must outlive this object and have no other writer.
  CellRanges(const DatasetInfo& info, Scratch& scratch);
  // Adds the next slices along z, at most 16, x fastest and of the dataset's type.
  void add(const Samples& slab, std::int32_t slices, const ForEach& for_each);
  // Returns the size of all ranges. After the last slice they are at the beginning of the scratch,
  // in the format of PreparedVolume::ranges.
  [[nodiscard]] std::uint64_t bytes() const;

 private:
  void spill(std::int32_t layers);

  const DatasetInfo info_;
  Scratch& scratch_;
  Samples ranges_;                // Pairs for the layers of cells in memory.
  std::int32_t first_layer_ = 0;  // The first of these layers, relative to cell_extent.
  std::int32_t next_slice_ = 0;
};

}  // namespace multitetra
