// The length of a dataset's unit in metres.
#pragma once

#include "common/dataset/dataset_info.hpp"
#include "common/dataset/length_units.hpp"

namespace multitetra {

// Returns the length of the dataset's unit; 1 if it is unknown.
[[nodiscard]] inline double metres_a_unit(const DatasetInfo& info) {
  return metres_of(info.meaning.length_unit).value_or(1);
}

}  // namespace multitetra
