// The length of a dataset's unit in metres.
#pragma once

#include <optional>
#include <string_view>

namespace multitetra {

// The metres of a unit given by name, such as "mm" or "micrometer"; none if it is no known length.
[[nodiscard]] std::optional<double> metres_of(std::string_view unit);

}  // namespace multitetra
