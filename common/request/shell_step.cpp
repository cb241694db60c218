#include "common/request/shell_step.hpp"

#include "common/codec/shell_encoder.hpp"

namespace multitetra {

double error_bound(const ShellStep& step, const DatasetInfo& info, std::int32_t finest_spacing) {
  if (step.values != shell::ShellValues::kQuantized) return 0;
  return shell::displacement_bound(step.levels_per_octave) * finest_spacing *
         longest_cell_diagonal(info);
}

}  // namespace multitetra
