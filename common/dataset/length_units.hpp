// Units of length: their symbols and lengths.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace multitetra {

// Returns the length in metres of a unit such as "mm" or "Micrometers", or none if it is unknown.
[[nodiscard]] std::optional<double> metres_of(std::string_view unit);

// Returns `text` if it can be a unit, else nothing. Replaces spellings of lengths by symbols
// ("millimeter" or "millimeters": "mm", "um" or "microns": "µm") and drops "pixel".
[[nodiscard]] std::string unit_from(std::string_view text);

}  // namespace multitetra
