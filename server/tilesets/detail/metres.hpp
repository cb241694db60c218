// Lengths of units in metres.
#pragma once

#include <optional>
#include <string_view>

namespace multitetra {

// Returns the length of a unit such as "mm" or "micrometer", or none if it is unknown.
[[nodiscard]] std::optional<double> metres_of(std::string_view unit);

}  // namespace multitetra
