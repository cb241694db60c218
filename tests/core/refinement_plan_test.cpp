#include "server/core/refinement_plan.hpp"

#include <gtest/gtest.h>

namespace multitetra {
namespace {

TEST(RefinementPlan, EndsWithExactlyTheRequest) {
  for (const double error : {0.0, 0.5, 3.0, 100.0}) {
    for (const bool previews : {false, true}) {
      const IsosurfaceRequest request{
          .isovalue = 3, .error = error, .topology_tolerance = 1, .lattice_resolution = 7};
      const auto steps = plan_steps(request, previews, 1);
      EXPECT_EQ(steps.back(), (StepRequest{.request = request, .finest_spacing = 1}));
    }
  }
}

TEST(RefinementPlan, HasPreviewsOfFallingErrorAndTolerance) {
  const auto steps = plan_steps({.error = 0.5}, true, 1);
  ASSERT_GE(steps.size(), 2U);
  for (std::size_t i = 0; i + 1 < steps.size(); ++i) {
    EXPECT_GT(steps[i].request.error, steps[i + 1].request.error);
    EXPECT_GT(steps[i].request.topology_tolerance, steps[i + 1].request.topology_tolerance);
    EXPECT_EQ(steps[i].request.isovalue, steps.back().request.isovalue);
  }
}

TEST(RefinementPlan, HasNoPreviewUnlessAskedFor) {
  EXPECT_EQ(plan_steps({.error = 0.5}, false, 1).size(), 1U);
}

TEST(RefinementPlan, HasNoPreviewThatIsNoCoarserThanTheRequest) {
  EXPECT_EQ(plan_steps({.error = 1, .topology_tolerance = 1e3}, true, 1).size(), 1U);
}

TEST(RefinementPlan, MeansTheSameInVoxelsAndInWorldUnits) {
  const auto voxels = plan_steps({.error = 0.5, .unit = LengthUnit::kVoxel}, true, 0.25);
  const auto world = plan_steps({.error = 0.5 * 0.25, .unit = LengthUnit::kWorld}, true, 0.25);
  ASSERT_EQ(voxels.size(), world.size());
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    EXPECT_DOUBLE_EQ(voxels[i].request.error * 0.25, world[i].request.error);
  }
}

}  // namespace
}  // namespace multitetra
