// The parameters of a step of sample shells, besides request and finest spacing: the values of its
// shells. Its surface is that of the uniform level of the spacing.
#pragma once

#include <cstdint>

#include "common/base/vec3.hpp"
#include "common/codec/shell_format.hpp"

namespace multitetra {

struct ShellStep {
  shell::ShellValues values = shell::ShellValues::kExact;
  int levels_per_octave = 0;  // 1, 2, 4 or 8 of quantized values, else 0.

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

// The largest displacement of a vertex by the shells, in world units, rounding to the lattice
// apart: quantized ones (1/2 - 1 / (1 + 2^(1/L))) of the longest edge, a diagonal of a cell of the
// level, others 0. At spacing 1 it bounds the two-sided Hausdorff distance to the full-resolution
// surface: vertices move along their edges, and what lies between them moves no farther.
[[nodiscard]] double error_bound(const ShellStep& step, const Vec3& sample_spacing,
                                 std::int32_t finest_spacing);

}  // namespace multitetra
