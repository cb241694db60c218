// Rounding that never decreases a bound.
#pragma once

#include <bit>
#include <cstdint>
#include <limits>

namespace multitetra {

// Returns the smallest float that is not below `value`. Requires value >= 0.
[[nodiscard]] inline float rounded_up(double value) {
  const float nearest = static_cast<float>(value);
  if (static_cast<double>(nearest) >= value) return nearest;
  return std::bit_cast<float>(std::bit_cast<std::uint32_t>(nearest) + 1);
}

// Returns the largest float that is not above `value`: a float exceeds `value` exactly when it
// exceeds the result. Requires a value that is not NaN.
[[nodiscard]] inline float rounded_down(double value) {
  constexpr float kMax = std::numeric_limits<float>::max();
  if (value >= static_cast<double>(kMax)) return kMax;
  if (value < -static_cast<double>(kMax)) return -std::numeric_limits<float>::infinity();
  const float nearest = static_cast<float>(value);
  if (static_cast<double>(nearest) <= value) return nearest;
  const auto bits = std::bit_cast<std::uint32_t>(nearest);
  if (nearest > 0) return std::bit_cast<float>(bits - 1);
  return nearest == 0 ? -std::numeric_limits<float>::denorm_min() : std::bit_cast<float>(bits + 1);
}

}  // namespace multitetra
