// Corrections of lattice-exact shells: the distance in lattice steps of a vertex from the position
// predicted by the levels of its edge's ends.
//
// From the end with the lower level (if equal: from the start of the edge), levels determine the
// vertex up to an interval. A correction is coded only if the interval contains more than one
// lattice point. The context is the difference of levels, which determines how close the cut is to
// a rounding boundary.
#pragma once

#include <stdint.h>

#include "common/codec/detail/level_scale.hpp"
#include "common/codec/detail/shell_model.hpp"

namespace multitetra::shell {

// Codes the steps from a to the vertex on the edge from a to b: `exact` when encoding.
template <typename Coder>
int32_t code_cut(Coder& coder, CorrectionModel& model, const LevelScale& scale, int32_t steps,
                 int32_t level_a, int32_t level_b, int32_t exact) {
  const int32_t about = scale.cut(level_a, level_b);
  if (level_a == 0 || level_b == 0) return about;
  const bool from_b = level_b < level_a;
  const int32_t difference = from_b ? level_a - level_b : level_b - level_a;
  const LevelScale::RoundingMargin rounding_margin = scale.rounding_margin(difference);
  if (rounding_margin.least == rounding_margin.greatest) return about;
  const int32_t guess = from_b ? steps - about : about;
  const int32_t cut = from_b ? steps - exact : exact;
  const int context = difference < CorrectionModel::kDifferences
                          ? static_cast<int>(difference)
                          : CorrectionModel::kDifferences - 1;
  int32_t found = guess;
  if (coder.bit(model.is_wrong[context], cut != guess)) {
    bool is_lower = rounding_margin.greatest == guess;
    if (rounding_margin.least < guess && guess < rounding_margin.greatest) {
      is_lower = coder.bit(model.is_lower[context], cut < guess);
    }
    const int32_t most =
        is_lower ? guess - rounding_margin.least : rounding_margin.greatest - guess;
    const int32_t wanted = is_lower ? guess - cut : cut - guess;
    int32_t distance = 1;
    while (distance < most) {
      const int32_t at =
          distance < CorrectionModel::kDistances ? distance : CorrectionModel::kDistances;
      if (!coder.bit(model.is_further[at - 1], distance < wanted)) break;
      ++distance;
    }
    found = is_lower ? guess - distance : guess + distance;
  }
  return from_b ? steps - found : found;
}

}  // namespace multitetra::shell
