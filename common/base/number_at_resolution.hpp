// Numbers with as many digits as their data have, whatever the size of the numbers.
//
//   number_at(5400000.25, 0.5 / 100)   -> "5400000.25": places of voxels of 0.5
//   number_at(1737400.0123, 4e-6)      -> "1737400.0123": values that vary by 0.4
#pragma once

#include <array>
#include <charconv>
#include <cmath>
#include <string>

#include "common/base/number_text.hpp"

namespace multitetra {

// Returns the decimal within half of `resolution` of the value, without trailing zeros after the
// point. A resolution that is not above 0 keeps all digits, without an exponent for numbers of
// usual size.
[[nodiscard]] inline std::string number_at(double value, double resolution) {
  constexpr double kMostFixed = 1e15;  // Beyond it, fixed digits would not be significant.
  constexpr int kMostDecimals = 17;
  constexpr double kLeastFixed = 1e-6;
  if (!(std::abs(value) < kMostFixed)) return shortest_text(value);
  std::array<char, 64> digits{};
  if (!(resolution > 0)) {
    if (value != 0 && std::abs(value) < kLeastFixed) return shortest_text(value);
    return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), value,
                                         std::chars_format::fixed)
                               .ptr};
  }
  const double needed = std::ceil(-std::log10(resolution) - 1e-9);
  if (needed > kMostDecimals) return shortest_text(value);
  const int decimals = needed > 0 ? static_cast<int>(needed) : 0;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value,
                                 std::chars_format::fixed, decimals)
                       .ptr;
  std::string text(digits.data(), end);
  if (decimals > 0) {
    text.erase(text.find_last_not_of('0') + 1);
    if (text.ends_with('.')) text.pop_back();
  }
  return text == "-0" ? "0" : text;
}

}  // namespace multitetra
