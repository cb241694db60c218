// Smooths the indicator of a label by the weights 1 4 6 4 1 along each axis; beyond the map's ends
// its last samples are repeated.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace multitetra {

inline constexpr std::int32_t kSmoothingReach = 2;
// Steps of the field's values from 0 to 1.
inline constexpr int kFieldSteps = 256;

[[nodiscard]] constexpr std::uint32_t smoothing_weight(std::int32_t away) {
  constexpr std::array<std::uint32_t, 3> kWeights = {6, 4, 1};
  return kWeights[static_cast<std::size_t>(away < 0 ? -away : away)];
}

// The smoothed indicator in steps, of its sum over all weights. Halves are rounded away from one
// half, so that the fields of two complementary indicators add up to 1.
[[nodiscard]] constexpr int smoothed_steps(std::uint32_t sum) {
  constexpr int kWhole = 1 << 12;  // 2^4 along an axis.
  const int over = static_cast<int>(sum) - kWhole / 2;
  const int steps = ((over < 0 ? -over : over) * kFieldSteps + kWhole / 2) / kWhole;
  return kFieldSteps / 2 + (over < 0 ? -steps : steps);
}

// What lies `step` away from `at`, of `side` samples.
[[nodiscard]] constexpr std::size_t clamped_step(std::int32_t at, std::int32_t step,
                                                 std::int32_t side) {
  return static_cast<std::size_t>(std::clamp(at + step, 0, side - 1));
}

}  // namespace multitetra
