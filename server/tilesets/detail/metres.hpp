// Lengths of units in metres.
#pragma once

#include <optional>
#include <string_view>

#include "common/dataset/dataset_info.hpp"

namespace multitetra {

// Returns the length of a unit such as "mm" or "micrometer", or none if it is unknown.
[[nodiscard]] std::optional<double> metres_of(std::string_view unit);

// Returns the length of the dataset's unit; 1 if it is unknown.
[[nodiscard]] double metres_a_unit(const DatasetInfo& info);

}  // namespace multitetra
