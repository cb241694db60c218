#include "common/request/shell_step.hpp"

#include <cmath>

#include "common/codec/shell_encoder.hpp"

namespace multitetra {

double error_bound(const ShellStep& step, const Vec3& sample_spacing, std::int32_t finest_spacing) {
  if (step.values != shell::ShellValues::kQuantized) return 0;
  const double of_an_edge = shell::displacement_bound(step.levels_per_octave) / std::sqrt(3.0);
  return of_an_edge * finest_spacing *
         std::hypot(sample_spacing[0], sample_spacing[1], sample_spacing[2]);
}

}  // namespace multitetra
