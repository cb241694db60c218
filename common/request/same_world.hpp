// Whether two datasets lie in one world, so that the values of one can color a surface of the
// other.
#pragma once

#include <string>

#include "common/request/dataset_info.hpp"

namespace multitetra {

// Why they do not: a sentence; empty when they do. Their world axes and length units are the same
// as far as both are known, and the boxes of their samples overlap. Two datasets without names of
// axes and units pass by their boxes alone.
[[nodiscard]] std::string world_mismatch(const DatasetInfo& surface, const DatasetInfo& values);

}  // namespace multitetra
