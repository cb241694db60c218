#include "server/core/refinement_plan.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace multitetra {
namespace {

DatasetInfo dataset(std::int32_t samples_a_side, double spacing) {
  DatasetInfo info;
  info.dims = {samples_a_side, samples_a_side, samples_a_side};
  info.spacing = {spacing, spacing, spacing};
  info.grid_exponent = grid_exponent_for(info.dims, 0);
  return info;
}

TEST(RefinementPlan, EndsWithExactlyTheRequest) {
  for (const double error : {0.0, 0.5, 3.0, 100.0}) {
    for (const bool previews : {false, true}) {
      const IsosurfaceRequest request{
          .isovalue = 3, .error = error, .topology_tolerance = 1, .lattice_resolution = 7};
      const auto steps = plan_steps(request, previews, dataset(129, 1));
      EXPECT_EQ(steps.back(), (StepRequest{.request = request, .finest_spacing = 1}));
    }
  }
}

TEST(RefinementPlan, HasPreviewsThatFallTowardsTheRequest) {
  const auto steps = plan_steps({.error = 0.5}, true, dataset(129, 1));
  ASSERT_EQ(steps.size(), 3U);
  for (std::size_t i = 0; i + 1 < steps.size(); ++i) {
    EXPECT_GT(steps[i].request.error, steps[i + 1].request.error);
    EXPECT_GT(steps[i].request.topology_tolerance, steps[i + 1].request.topology_tolerance);
    EXPECT_GT(steps[i].finest_spacing, steps[i + 1].finest_spacing);
    EXPECT_EQ(steps[i].request.isovalue, steps.back().request.isovalue);
  }
}

TEST(RefinementPlan, HasNoPreviewUnlessAskedFor) {
  EXPECT_EQ(plan_steps({.error = 0.5}, false, dataset(129, 1)).size(), 1U);
}

TEST(RefinementPlan, HasPreviewsAlsoWhereTheRequestItselfToleratesMuch) {
  const auto steps = plan_steps({.error = 1, .topology_tolerance = 1e3}, true, dataset(129, 1));
  ASSERT_EQ(steps.size(), 3U);
  for (const StepRequest& step : steps) EXPECT_EQ(step.request.topology_tolerance, 1e3);
}

TEST(RefinementPlan, IsCoarserForARequestThatAllowsMore) {
  const auto fine = plan_steps({.error = 0.5}, true, dataset(513, 1));
  const auto coarse = plan_steps({.error = 4}, true, dataset(513, 1));
  EXPECT_LT(fine.front().finest_spacing, coarse.front().finest_spacing);
}

TEST(RefinementPlan, BeginsCoarserInALargeGrid) {
  EXPECT_EQ(plan_steps({.error = 0.5}, true, dataset(257, 1)).front().finest_spacing, 8);
  EXPECT_EQ(plan_steps({.error = 0.5}, true, dataset(400, 1)).front().finest_spacing, 16);
}

TEST(RefinementPlan, HasFiniteErrorsHoweverLargeTheRequestIs) {
  for (const StepRequest& step : plan_steps({.error = 1e308}, true, dataset(513, 1))) {
    EXPECT_TRUE(std::isfinite(step.request.error));
  }
}

TEST(RefinementPlan, HasNoPreviewThatASmallGridCannotShow) {
  EXPECT_EQ(plan_steps({.error = 1}, true, dataset(9, 1)).size(), 1U);
  EXPECT_EQ(plan_steps({.error = 1}, true, dataset(33, 1)).size(), 2U);
}

TEST(RefinementPlan, MeansTheSameInVoxelsAndInWorldUnits) {
  const DatasetInfo info = dataset(129, 0.25);
  const auto voxels = plan_steps({.error = 0.5, .unit = LengthUnit::kVoxel}, true, info);
  const auto world = plan_steps({.error = 0.5 * 0.25, .unit = LengthUnit::kWorld}, true, info);
  ASSERT_EQ(voxels.size(), world.size());
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    EXPECT_DOUBLE_EQ(voxels[i].request.error * 0.25, world[i].request.error);
  }
}

}  // namespace
}  // namespace multitetra
