#include "client/commands/fetched_surface.hpp"

#include <iostream>

#include "client/library/report.hpp"

namespace multitetra {

void finish(OutputPart& part, const CommittedStep& step,
            const std::optional<ScalarRequest>& scalars, const SurfaceArguments& arguments,
            const OutputArguments& output) {
  part.report.request = step.begin.request;
  part.report.surface = whole_surface(step);
  part.report.colors = step.begin.scalars;
  if (scalars) part.report.color_by = scalars->dataset;
  finish(part, step.mesh, arguments, output);
  if (!step.begin.scalars || output.quiet) return;
  std::cerr << color_accuracy_text(*step.begin.scalars, step.largest_scalar_deviation) << std::endl;
}

}  // namespace multitetra
