#include "common/codec/detail/level_scale.hpp"

namespace multitetra::shell {

namespace {

// Returns 2^(eighths / 8) in units of 2^-30, for eighths >= 0, limited to two octaves above the
// largest number of lattice steps.
uint64_t power(int32_t eighths) {
  constexpr int32_t kMaxEighths = 8 * (kMaxShellLatticeBits + 2);
  const int32_t bounded = eighths < kMaxEighths ? eighths : kMaxEighths;
  return uint64_t{kEighthPowers[bounded % 8]} << (bounded / 8);
}

// Returns steps / (1 + 2^(difference / L)) + 1/2 + about 2^-20 times `nudge`, rounded down and
// clamped to the edge's inner lattice points.
int32_t cut_at(int32_t steps, int32_t eighths, int nudge) {
  constexpr uint64_t kOne = uint64_t{1} << 30;
  // Avoids negative exponents by symmetry.
  const uint64_t divisor = kOne + power(eighths < 0 ? -eighths : eighths);
  const uint64_t dividend = eighths < 0 ? divisor - kOne : kOne;
  uint64_t twice = 2 * static_cast<uint64_t>(steps) * dividend + divisor;
  const uint64_t shift = divisor >> 19;
  twice = nudge < 0 ? twice - shift : nudge > 0 ? twice + shift : twice;
  const auto cut = static_cast<int64_t>(twice / (2 * divisor));
  return cut < 1 ? 1 : cut > steps - 1 ? steps - 1 : static_cast<int32_t>(cut);
}

}  // namespace

void LevelScale::begin(const ShellHeader& header) {
  levels_log2_ = floor_log2(static_cast<uint32_t>(header.levels_per_octave));
  levels_ = header.levels;
  steps_ = header.steps();
  const int32_t eighths_a_level = 8 >> levels_log2_;
  // The level of 2^unit_exponent, which is magnitude 1.
  const int32_t unit_level = header.unit_exponent * header.levels_per_octave;
  first_ = unit_level - header.first_level + 1;
  magnitudes_[0] = 0;
  for (int32_t i = 1; i < levels_; ++i) {
    const int32_t eighths = (header.first_level + i - 1 - unit_level) * eighths_a_level;
    if (eighths < 0) {
      magnitudes_[i] = 1;
    } else if (eighths >= 8 * 16) {
      magnitudes_[i] = kMaxMagnitude;
    } else {
      const uint64_t rounded = (power(eighths) + (1U << 29)) >> 30;
      magnitudes_[i] = rounded > kMaxMagnitude ? kMaxMagnitude : static_cast<int32_t>(rounded);
    }
  }
  for (int32_t i = 0; i <= kMaxDifference; ++i) cuts_[i] = cut_at(steps_, i * eighths_a_level, 0);
  if (header.values != ShellValues::kLatticeExact) return;
  for (int32_t i = 0; i <= kMaxMarginDifference; ++i) {
    rounding_margins_[i] = {.least = static_cast<int16_t>(cut_at(steps_, i + 1, -1)),
                            .greatest = static_cast<int16_t>(cut_at(steps_, i - 1, 1))};
  }
}

}  // namespace multitetra::shell
