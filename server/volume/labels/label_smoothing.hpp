// Smooths the indicator of a label by the weights 1 4 6 4 1 along each axis. Beyond the ends of the
// map, its last samples are repeated.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace multitetra {

inline constexpr std::int32_t kSmoothingReach = 2;
// Number of steps of the field's values from 0 to 1.
inline constexpr int kFieldSteps = 256;

[[nodiscard]] constexpr std::uint32_t smoothing_weight(std::int32_t away) {
  constexpr std::array<std::uint32_t, 3> kWeights = {6, 4, 1};
  return kWeights[static_cast<std::size_t>(away < 0 ? -away : away)];
}

// Converts a weighted sum to the smoothed indicator in steps. Rounds halves away from one half, so
// that the fields of two complementary indicators add up to 1.
[[nodiscard]] constexpr int smoothed_steps(std::uint32_t sum) {
  constexpr int kWhole = 1 << 12;  // 2^4 for each axis.
  const int over = static_cast<int>(sum) - kWhole / 2;
  const int steps = ((over < 0 ? -over : over) * kFieldSteps + kWhole / 2) / kWhole;
  return kFieldSteps / 2 + (over < 0 ? -steps : steps);
}

// Returns the position `step` away from `at`, clamped to `side` samples.
[[nodiscard]] constexpr std::size_t clamped_step(std::int32_t at, std::int32_t step,
                                                 std::int32_t side) {
  return static_cast<std::size_t>(std::clamp(at + step, 0, side - 1));
}

}  // namespace multitetra
