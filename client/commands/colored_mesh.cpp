#include "client/commands/colored_mesh.hpp"

#include "common/cli/human_units.hpp"

namespace multitetra {

void paint(PositionedMesh& mesh, const StepBegin& step, ColorScale scale) {
  if (!step.scalars || mesh.scalars.empty()) return;
  scale.low = step.scalars->low;
  scale.high = step.scalars->high;
  mesh.colors = colors_of(mesh.scalars, scale);
}

std::string accuracy_text(const CommittedStep& step) {
  if (!step.begin.scalars) return {};
  return "Colors between vertices may be off by up to " +
         human_number(step.largest_scalar_deviation) + ", those of vertices by " +
         human_number(0.5 * step.begin.scalars->step()) + ".";
}

}  // namespace multitetra
