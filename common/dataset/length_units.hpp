// Units of length: their symbols and lengths.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace multitetra {

// Returns the length in metres of a unit such as "mm" or "Micrometers", or none if it is unknown.
[[nodiscard]] std::optional<double> metres_of(std::string_view unit);

// Returns the factor from lengths in `unit` to those in `other`, a whole number or one divided by a
// whole number where it is that; none if either is unknown.
[[nodiscard]] std::optional<double> length_factor(std::string_view unit, std::string_view other);

// Returns `text` if it can be a unit, else nothing. Replaces spellings of lengths by symbols
// ("millimeter" or "millimeters": "mm", "um" or "microns": "µm") and drops "pixel".
[[nodiscard]] std::string unit_from(std::string_view text);

}  // namespace multitetra
