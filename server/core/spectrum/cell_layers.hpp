// The per-cell data of a prepared volume, computed from boxes of samples, for callers with a part
// of the volume. CellRanges and CoarseVolume compute the same from a whole volume, slice by slice.
#pragma once

#include <cstddef>
#include <vector>

#include "common/dataset/dataset_info.hpp"
#include "server/core/framework/for_each.hpp"
#include "server/core/spectrum/spectrum_builder.hpp"
#include "server/core/spectrum/spectrum_inputs.hpp"

namespace multitetra {

// Returns the ranges of one layer of the cells of cell_extent(info), at z = `layer` and from
// cells.begin to cells.end along x and y, in the format of PreparedVolume::ranges.
[[nodiscard]] std::vector<std::byte> ranges_of_layer(const DatasetInfo& info,
                                                     const SampleBoxes& samples,
                                                     const CellBox& cells, std::int32_t layer,
                                                     const ForEach& for_each);

// Returns one layer of the samples of coarse_extent(info), at z = `layer` and from points.begin to
// points.end along x and y, in the format of PreparedVolume::coarse.
[[nodiscard]] std::vector<std::byte> coarse_of_layer(const DatasetInfo& info,
                                                     const SampleBoxes& samples,
                                                     const CellBox& points, std::int32_t layer,
                                                     const ForEach& for_each);

}  // namespace multitetra
