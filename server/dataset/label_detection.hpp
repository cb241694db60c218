// Detects whether a volume is a label map.
#pragma once

#include "common/dataset/dataset_info.hpp"
#include "server/core/spectrum/sample_bricks.hpp"

namespace multitetra {

// Returns whether all samples are integers and most of the values occur in regions, not in single
// samples, as in label maps. Reads at most 1024 bricks of `samples`, the section of a dataset.
// Throws what reading a brick throws.
[[nodiscard]] bool looks_like_labels(const DatasetInfo& info, const BrickSource& samples);

}  // namespace multitetra
