// Estimates the size of a step's sample shells from the coarse samples alone.
#pragma once

#include "server/core/planning/shell_steps.hpp"
#include "server/core/spectrum/prepared_volume.hpp"

namespace multitetra {

// Requires a step of shells. Accurate within a factor of two for smooth fields; too low for fields
// that are rough below kSpectrumSpacing.
[[nodiscard]] SurfaceSize shell_size(const PreparedVolume& volume, const StepRequest& step);

}  // namespace multitetra
