// The adaptive model of the coder: probabilities by context. They start from trained values, which
// helps small tiles, and adapt to the tile.
#pragma once

#include <stdint.h>

#include "common/codec/detail/range_coder.hpp"
#include "common/codec/shell_format.hpp"

namespace multitetra::shell {

// The model of a field of bits; see sign_coder.hpp.
struct SignModel {
  static constexpr int kBlockContexts = 108;
  static constexpr int kSampleContexts = 1 << 12;

  Probability block_is_mixed[kBlockContexts];
  Probability block_is_ones[kBlockContexts];
  Probability sample[kSampleContexts];
};

// The model of the residuals of predicted values; see magnitude_coder.hpp.
struct ValueModel {
  static constexpr int kScales = 24;   // Half octaves of the typical error of a prediction.
  static constexpr int kSupports = 4;  // Classes of the number of neighbors.
  static constexpr int kPlaces = 6;    // Classes of the distance to the least value.
  static constexpr int kExponents = 18;

  Probability is_missed[kScales * kSupports][kPlaces];
  Probability is_too_high[kScales * kSupports][kPlaces];
  Probability is_longer[kScales * kSupports][2][kExponents];
  Probability mantissa[kExponents][2][3];
};

// The model of lattice-exact corrections, by the difference of levels along the edge; see
// corrections.hpp.
struct CorrectionModel {
  static constexpr int kDifferences = 96;
  static constexpr int kDistances = 8;

  Probability is_wrong[kDifferences];
  Probability is_lower[kDifferences];
  Probability is_further[kDistances];
};

struct ShellModel {
  SignModel presence;
  SignModel signs;
  ValueModel values;
  CorrectionModel corrections;

  void begin(ShellValues kind);
};

}  // namespace multitetra::shell
