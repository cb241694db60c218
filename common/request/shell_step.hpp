// The parameters of a step of sample shells besides request and finest spacing. Its surface is that
// of the uniform level of that spacing.
#pragma once

#include <cstdint>

#include "common/codec/shell_format.hpp"
#include "common/dataset/dataset_info.hpp"

namespace multitetra {

struct ShellStep {
  shell::ShellValues values = shell::ShellValues::kExact;
  int levels_per_octave = 0;  // 1, 2, 4 or 8 for quantized values, otherwise 0.

  friend bool operator==(const ShellStep&, const ShellStep&) = default;
};

[[nodiscard]] constexpr ShellStep quantized_shells(int levels_per_octave) {
  return {.values = shell::ShellValues::kQuantized, .levels_per_octave = levels_per_octave};
}

[[nodiscard]] constexpr bool is_possible(const ShellStep& step) {
  const int levels = step.levels_per_octave;
  if (step.values != shell::ShellValues::kQuantized) return levels == 0;
  return levels == 1 || levels == 2 || levels == 4 || levels == 8;
}

// Returns the largest displacement of a vertex by the shells' values, in world units and without
// rounding to the lattice: (1/2 - 1 / (1 + 2^(1/L))) of the longest edge, a cell diagonal of the
// level, for quantized values, otherwise 0. At spacing 1 it bounds the two-sided Hausdorff distance
// to the full-resolution surface: vertices move along edges, and points between them no farther.
[[nodiscard]] double error_bound(const ShellStep& step, const DatasetInfo& info,
                                 std::int32_t finest_spacing);

}  // namespace multitetra
