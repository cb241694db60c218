#include "server/core/planning/cost_estimates.hpp"

#include <algorithm>

namespace multitetra {
namespace {

constexpr double kWeight = 0.3;
constexpr double kLeastTriangles = 2000;  // Fewer are no basis for the cost of each.
constexpr double kMostAtOnce = 3;         // One step that had to wait is no new machine.

}  // namespace

void MeasuredCosts::note(StepForm form, double extracted, double seconds) {
  if (extracted < kLeastTriangles) return;
  double& known = form == StepForm::kShells       ? costs_.shells
                  : form == StepForm::kSimplified ? costs_.simplified
                  : form == StepForm::kEmbedded   ? costs_.embedded
                                                  : costs_.plain;
  const double found = std::max(seconds - CostEstimates::kSecondsAStep, 0.0) / extracted;
  known += kWeight * (std::clamp(found, known / kMostAtOnce, known * kMostAtOnce) - known);
}

}  // namespace multitetra
