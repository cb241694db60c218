#include "server/core/planning/budget.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace multitetra {
namespace {

DatasetInfo dataset(double spacing = 1) {
  DatasetInfo info;
  info.dims = {257, 257, 257};
  info.spacing = {spacing, spacing, spacing};
  info.grid_exponent = 8;
  return info;
}

// A noisy surface: the floor of thresholds thins it out down to what topology needs, which only the
// tolerance lets go.
SurfaceSize noisy_surface(const StepRequest& step) {
  const IsosurfaceRequest& request = step.request;
  const double error = std::max(request.error, request.thresholds.at_least);
  const double topology = 2e5 / std::pow(1 + request.topology_tolerance, 3);
  const double triangles = topology + 1e6 / (1 + error);
  return {.triangles = triangles, .bytes = 1.3 * triangles};
}

IsosurfaceRequest request_for(std::uint64_t max_triangles, std::uint64_t max_bytes = 0) {
  return {.isovalue = 1, .error = 0.25, .max_triangles = max_triangles, .max_bytes = max_bytes};
}

TEST(Budget, LeavesARequestAloneThatHasNoneOrFits) {
  for (const std::uint64_t triangles : {std::uint64_t{0}, std::uint64_t{5'000'000}}) {
    const IsosurfaceRequest request = request_for(triangles);
    EXPECT_EQ(within_budget(request, dataset(), noisy_surface), request);
  }
}

TEST(Budget, IsMetByTheLowestFloorOfThresholds) {
  for (const std::uint64_t triangles : {900'000U, 500'000U, 300'000U}) {
    const IsosurfaceRequest found = within_budget(request_for(triangles), dataset(), noisy_surface);
    EXPECT_EQ(found.topology_tolerance, 0);
    EXPECT_GT(found.thresholds.at_least, 0);
    EXPECT_TRUE(fits(noisy_surface({found}), found));
    IsosurfaceRequest lower = found;
    lower.thresholds.at_least /= 2;
    EXPECT_FALSE(fits(noisy_surface({lower}), lower)) << triangles;
  }
}

TEST(Budget, GivesTopologyUpOnlyWhereNoThresholdHelps) {
  const IsosurfaceRequest found = within_budget(request_for(100'000), dataset(), noisy_surface);
  EXPECT_GT(found.topology_tolerance, 0);
  EXPECT_LE(found.topology_tolerance, 1);
  EXPECT_TRUE(fits(noisy_surface({found}), found));
}

TEST(Budget, CountsBytesToo) {
  const IsosurfaceRequest found = within_budget(request_for(0, 500'000), dataset(), noisy_surface);
  EXPECT_LE(noisy_surface({found}).bytes, 500'000);
  EXPECT_GT(noisy_surface({found}).bytes, 250'000);
}

TEST(Budget, MeansTheSameInWorldUnits) {
  IsosurfaceRequest world = request_for(300'000);
  world.unit = LengthUnit::kWorld;
  world.error = 0.25 * 0.5;
  const auto size_of = [](StepRequest step) {  // In voxels of half a world unit.
    step.request.error /= 0.5;
    step.request.thresholds.at_least /= 0.5;
    return noisy_surface(step);
  };
  const IsosurfaceRequest voxels = within_budget(request_for(300'000), dataset(0.5), noisy_surface);
  EXPECT_DOUBLE_EQ(within_budget(world, dataset(0.5), size_of).thresholds.at_least,
                   0.5 * voxels.thresholds.at_least);
}

TEST(Budget, AsksForFewSizes) {
  int asked = 0;
  (void)within_budget(request_for(1), dataset(), [&asked](const StepRequest& step) {
    ++asked;
    return noisy_surface(step);
  });
  EXPECT_LE(asked, 10);
}

TEST(Budget, OneRungUpGivesUpALittleMoreUntilNothingIsLeft) {
  const DatasetInfo info = dataset();
  IsosurfaceRequest request = request_for(1);
  double size = std::numeric_limits<double>::max();
  int rungs = 0;
  for (;; ++rungs) {
    ASSERT_LT(rungs, 200);
    const IsosurfaceRequest higher = one_rung_up(request, info);
    if (higher == request) break;
    EXPECT_GE(higher.thresholds.at_least, request.thresholds.at_least);
    EXPECT_GE(higher.topology_tolerance, request.topology_tolerance);
    if (higher.thresholds.at_least > request.error) {
      EXPECT_LT(noisy_surface({higher}).triangles, size);
    }
    size = noisy_surface({higher}).triangles;
    request = higher;
  }
  EXPECT_GT(rungs, 30);
  EXPECT_GE(request.topology_tolerance, 256);
}

}  // namespace
}  // namespace multitetra
