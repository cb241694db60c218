// Values on a logarithmic scale: |v - c| as the number of a level, L of them an octave.
//
// Level i >= 1 stands for |v - c| near 2^((first_level + i - 1) / L), level 0 for v = c. Where a
// crossed edge is cut then depends on the difference of its ends' levels alone:
//
//   t = 1 / (1 + 2^((level(b) - level(a)) / L))     from a
//
// To predict levels from their neighbours, they are turned into integers, about in proportion to
// |v - c|, with 2^10 for the tile's median. All of it is integer arithmetic: the same on every
// machine.
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
  // 0 for level 0, else 1 .. kMaxMagnitude.
  [[nodiscard]] int32_t magnitude(int32_t level) const { return magnitudes_[level]; }
  // The level of a magnitude >= 0, about.
  [[nodiscard]] int32_t level(int32_t magnitude) const {
    if (magnitude < 1) return 0;
    const auto value = static_cast<uint32_t>(magnitude);
    const int octave = floor_log2(value);
    const uint32_t mantissa = (value << (31 - octave)) >> 26 & 31U;
    const int32_t eighths = 8 * octave + kEighthsOfMantissa[mantissa];
    const int32_t level = ((eighths + (4 >> levels_log2_)) >> (3 - levels_log2_)) + first_;
    return level < 0 ? 0 : level >= levels_ ? levels_ - 1 : level;
  }
  // By how many half octaves a magnitude's half octaves rise to become those of levels.
  [[nodiscard]] int half_octaves_of_levels() const { return 2 * levels_log2_; }

  // Steps from a, 1 .. steps - 1, to the vertex on the edge from a to b.
  [[nodiscard]] int32_t cut(int32_t level_a, int32_t level_b) const {
    if (level_a == 0) return 1;
    if (level_b == 0) return steps_ - 1;
    const int32_t difference = level_b - level_a;
    if (difference < 0)
      return steps_ - cuts_[difference < -kMaxDifference ? kMaxDifference : -difference];
    return cuts_[difference > kMaxDifference ? kMaxDifference : difference];
  }

  // Where the exact vertex can lie when a has the lower level, so that 0 <= difference: the least
  // and greatest distance from a. Lattice-exact shells only.
  struct RoundingMargin {
    int16_t least = 1;
    int16_t greatest = 1;
  };
  [[nodiscard]] RoundingMargin rounding_margin(int32_t difference) const {
    return doubts_[difference > kMaxDoubtful ? kMaxDoubtful : difference];
  }

 private:
  // From there on all cuts are next to an end: 2^(difference / L) > the lattice steps of an edge.
  static constexpr int32_t kMaxDifference = 8 * (kMaxShellLatticeBits + 2);
  static constexpr int32_t kMaxDoubtful = 8 * (8 + 2);
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
  RoundingMargin doubts_[kMaxDoubtful + 1];
};

}  // namespace multitetra::shell
