// A logarithmic scale for |v - c|, with L levels per octave.
//
// Level i >= 1 stands for |v - c| near 2^((first_level + i - 1) / L), level 0 for v = c. The cut of
// a crossed edge then depends only on the difference of its ends' levels:
//
//   t = 1 / (1 + 2^((level(b) - level(a)) / L))     from a
//
// For predictions, levels are converted to integers about proportional to |v - c|, with 2^10 for
// the tile's median. Integer arithmetic makes them the same on every machine.
#pragma once

#include <stdint.h>

#include "common/codec/detail/powers_of_two.hpp"
#include "common/codec/shell_format.hpp"

namespace multitetra::shell {

inline constexpr int32_t kMaxMagnitude = (1 << 16) - 1;  // For predictions.

class LevelScale {
 public:
  void begin(const ShellHeader& header);

  [[nodiscard]] int32_t levels() const { return levels_; }
  // Returns 0 for level 0, otherwise 1 .. kMaxMagnitude.
  [[nodiscard]] int32_t magnitude(int32_t level) const { return magnitudes_[level]; }
  // Returns the approximate level of a magnitude >= 0.
  [[nodiscard]] int32_t level(int32_t magnitude) const {
    if (magnitude < 1) return 0;
    const auto value = static_cast<uint32_t>(magnitude);
    const int octave = floor_log2(value);
    const uint32_t mantissa = (value << (31 - octave)) >> 26 & 31U;
    const int32_t eighths = 8 * octave + kEighthsOfMantissa[mantissa];
    const int32_t level = ((eighths + (4 >> levels_log2_)) >> (3 - levels_log2_)) + first_;
    return level < 0 ? 0 : level >= levels_ ? levels_ - 1 : level;
  }
  // Returns the half octaves to add to those of a magnitude to obtain those of levels.
  [[nodiscard]] int half_octaves_of_levels() const { return 2 * levels_log2_; }

  // Returns the steps from a, 1 .. steps - 1, to the vertex on the edge from a to b.
  [[nodiscard]] int32_t cut(int32_t level_a, int32_t level_b) const {
    if (level_a == 0) return 1;
    if (level_b == 0) return steps_ - 1;
    const int32_t difference = level_b - level_a;
    if (difference < 0)
      return steps_ - cuts_[difference < -kMaxDifference ? kMaxDifference : -difference];
    return cuts_[difference > kMaxDifference ? kMaxDifference : difference];
  }

  // The least and greatest possible distance of the exact vertex from a, if a has the lower level
  // (difference >= 0). For lattice-exact shells only.
  struct RoundingMargin {
    int16_t least = 1;
    int16_t greatest = 1;
  };
  [[nodiscard]] RoundingMargin rounding_margin(int32_t difference) const {
    return rounding_margins_[difference > kMaxMarginDifference ? kMaxMarginDifference : difference];
  }

 private:
  // Beyond it all cuts are next to an end: 2^(difference / L) exceeds the lattice steps of an edge.
  static constexpr int32_t kMaxDifference = 8 * (kMaxShellLatticeBits + 2);
  static constexpr int32_t kMaxMarginDifference = 8 * (8 + 2);
  // The logarithms of 1 + (i + 1/2) / 32, in eighths of an octave, rounded.
  static constexpr uint8_t kEighthsOfMantissa[32] = {0, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3,
                                                     4, 4, 4, 4, 5, 5, 5, 5, 5, 6, 6,
                                                     6, 6, 7, 7, 7, 7, 7, 8, 8, 8};

  int levels_log2_ = 0;
  int32_t levels_ = 1;
  int32_t steps_ = 2;
  int32_t first_ = 0;  // The level of magnitude 1.
  int32_t magnitudes_[kMaxLevels] = {};
  int32_t cuts_[kMaxDifference + 1] = {};
  RoundingMargin rounding_margins_[kMaxMarginDifference + 1];
};

}  // namespace multitetra::shell
