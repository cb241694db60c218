// The least and the largest sample of every cell, so that a query finds the cells that a surface
// can cross without a look at their samples.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/dataset_info.hpp"
#include "server/core/for_each.hpp"
#include "server/core/volume.hpp"

namespace multitetra {

// Collects the ranges of cell_extent(info) from a volume that passes by once.
class CellRanges {
 public:
  explicit CellRanges(const DatasetInfo& info);
  // The next slices along z, x fastest in the dataset's type.
  void add(const Samples& slab, std::int32_t slices, const ForEach& for_each);
  // As PreparedVolume::ranges.
  [[nodiscard]] std::span<const std::byte> bytes() const;

 private:
  const DatasetInfo info_;
  Samples ranges_;  // Pairs.
  std::int32_t next_slice_ = 0;
};

}  // namespace multitetra
