// Checks whether two datasets lie in one world, so that the values of one can color a surface of
// the other.
#pragma once

#include <string>

#include "common/dataset/dataset_info.hpp"

namespace multitetra {

// Returns the reason why they do not, as a sentence, or nothing if they do: world axes and length
// units are equal where both are known, and the boxes of the samples overlap. For two datasets
// without known axes and units only the boxes count.
[[nodiscard]] std::string world_mismatch(const DatasetInfo& surface, const DatasetInfo& values);

}  // namespace multitetra
