#include "server/core/planning/shell_steps.hpp"

#include <array>
#include <cmath>

#include "server/core/framework/level_extent.hpp"
#include "server/core/planning/budget.hpp"
#include "server/core/thresholds/threshold_map.hpp"

namespace multitetra {

bool has_shells(const DatasetInfo& info, const ShellLevel& level) {
  const int spacing_exponent = exponent_of(level.finest_spacing);
  if (spacing_exponent >= info.grid_exponent || spacing_exponent > shell::kMaxSpacingExponent) {
    return false;
  }
  if (level.shell.values == shell::ShellValues::kExact) {
    return info.type != SampleType::kF32 && std::abs(level.isovalue) <= shell::kMaxExactValue - 1;
  }
  if (level.shell.values == shell::ShellValues::kLatticeExact &&
      level.finest_spacing << level.lattice_resolution > shell::kMaxExactSteps) {
    return false;
  }
  // Then distances to floats span at most 282 octaves of the 320 that shells can represent.
  return level.isovalue == 0 ||
         (std::abs(level.isovalue) >= 0x1p-100 && std::abs(level.isovalue) <= 0x1p200);
}

std::optional<StepRequest> certified_shells(const IsosurfaceRequest& request,
                                            const DatasetInfo& info) {
  using shell::ShellValues;
  constexpr std::array<ShellStep, 6> kModes = {quantized_shells(1),
                                               quantized_shells(2),
                                               quantized_shells(4),
                                               quantized_shells(8),
                                               ShellStep{.values = ShellValues::kExact},
                                               ShellStep{.values = ShellValues::kLatticeExact}};
  const double least = ThresholdMap(request, info).least();
  std::optional<StepRequest> cheapest;
  double bits = 0;
  for (const ShellStep& shell : kModes) {
    if (error_bound(shell, info, 1) > least) continue;
    const StepRequest step = preview_step(request, {.finest_spacing = 1, .shell = shell}, info);
    if (!has_shells(info, level_of(step))) continue;
    const double bits_of_step = bits_per_vertex(shell, info.type, request.lattice_resolution);
    if (cheapest && bits_of_step >= bits) continue;
    cheapest = step;
    bits = bits_of_step;
  }
  return cheapest;
}

bool is_enough_to_display(const StepRequest& step, const IsosurfaceRequest& request,
                          const DatasetInfo& info) {
  if (!step.shell || step.finest_spacing != 1 || has_budget(request)) return false;
  const double least = ThresholdMap(request, info).least();
  return least < voxel_length(info) && error_bound(*step.shell, info, 1) <= least;
}

}  // namespace multitetra
