#include "client/commands/colored_mesh.hpp"

#include "common/cli/surface_options.hpp"

namespace multitetra {

std::string accuracy_text(const CommittedStep& step) {
  if (!step.begin.scalars) return {};
  return color_accuracy_text(*step.begin.scalars, step.largest_scalar_deviation);
}

}  // namespace multitetra
