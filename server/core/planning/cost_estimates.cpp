#include "server/core/planning/cost_estimates.hpp"

#include <algorithm>

namespace multitetra {
namespace {

constexpr double kWeight = 0.3;
constexpr double kMinTriangles = 2000;  // Fewer give no reliable cost per triangle.
constexpr double kMaxChangeFactor = 3;  // Limits the effect of a single delayed step.

}  // namespace

void MeasuredCosts::record(StepForm form, double extracted, double seconds) {
  if (extracted < kMinTriangles) return;
  double& known = form == StepForm::kShells             ? costs_.shells
                  : form == StepForm::kSimplified       ? costs_.simplified
                  : form == StepForm::kIntersectionFree ? costs_.intersection_free
                                                        : costs_.plain;
  const double found = std::max(seconds - CostEstimates::kSecondsPerStep, 0.0) / extracted;
  known +=
      kWeight * (std::clamp(found, known / kMaxChangeFactor, known * kMaxChangeFactor) - known);
}

}  // namespace multitetra
