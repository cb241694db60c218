// Logarithms and powers of two in eighths, as integers, so they are the same on every machine.
#pragma once

#include <stdint.h>

namespace multitetra::shell {

// 2^(i / 8) in units of 2^-30, rounded.
inline constexpr uint32_t kEighthPowers[8] = {1073741824, 1170923762, 1276901417, 1392470869,
                                              1518500250, 1655936265, 1805811301, 1969251188};

[[nodiscard]] inline int floor_log2(uint32_t v) { return 31 - __builtin_clz(v); }

// Returns the base-2 logarithm in half octaves: 0 for 0, 1 for 1, 2, 3 for 2, 3, ...
[[nodiscard]] inline int half_octaves(uint32_t v) {
  if (v < 2) return static_cast<int>(v);
  const int octave = floor_log2(v);
  return 2 * octave + static_cast<int>(v >> (octave - 1) & 1U);
}

}  // namespace multitetra::shell
