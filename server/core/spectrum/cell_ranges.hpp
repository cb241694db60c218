// The least and the largest sample of every cell, so that a query finds the cells that a surface
// can cross without a look at their samples.
#pragma once

#include <cstddef>
#include <cstdint>

#include "common/request/dataset_info.hpp"
#include "server/core/framework/for_each.hpp"
#include "server/core/framework/volume.hpp"
#include "server/core/spectrum/spectrum_inputs.hpp"

namespace multitetra {

// Collects the ranges of cell_extent(info) from a volume that passes by once, and puts them aside
// layer after layer: a few layers of cells are in memory.
class CellRanges {
 public:
  // The scratch must outlive this, and nothing else may put into it.
  CellRanges(const DatasetInfo& info, Scratch& scratch);
  // The next slices along z, at most 16, x fastest in the dataset's type.
  void add(const Samples& slab, std::int32_t slices, const ForEach& for_each);
  // The size of all ranges together, which lie in the scratch, from its beginning, as
  // PreparedVolume::ranges, once the last slice was added.
  [[nodiscard]] std::uint64_t bytes() const;

 private:
  void spill(std::int32_t layers);

  const DatasetInfo info_;
  Scratch& scratch_;
  Samples ranges_;                // Pairs, of some layers of cells.
  std::int32_t first_layer_ = 0;  // The first of these, relative to cell_extent.
  std::int32_t next_slice_ = 0;
};

}  // namespace multitetra
