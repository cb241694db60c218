// The values that a display shows as its darkest and its brightest color.
#pragma once

#include <cmath>

namespace multitetra {

struct DisplayWindow {
  double low = 0;   // Finite.
  double high = 1;  // Finite, above `low`.

  friend bool operator==(const DisplayWindow&, const DisplayWindow&) = default;
};

[[nodiscard]] inline bool is_valid(const DisplayWindow& window) {
  return std::isfinite(window.low) && std::isfinite(window.high) && window.low < window.high;
}

}  // namespace multitetra
