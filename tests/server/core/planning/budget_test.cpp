#include "server/core/planning/budget.hpp"

#include <cmath>

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

// The size of a noisy surface: raising the threshold floor removes all triangles but those that the
// topology needs; only the topology tolerance removes these.
SurfaceSize noisy_surface(const StepRequest& step) {
  const IsosurfaceRequest& request = step.request;
  const double error = std::max(request.error, request.thresholds.error_floor);
  const double topology = 2e5 / std::pow(1 + request.topology_tolerance, 3);
  const double triangles = topology + 1e6 / (1 + error);
  return {.triangles = triangles, .bytes = 1.3 * triangles};
}

IsosurfaceRequest request_for(std::uint64_t max_triangles, std::uint64_t max_bytes = 0) {
  return {.isovalue = 1, .error = 0.25, .max_triangles = max_triangles, .max_bytes = max_bytes};
}

TEST(Budget, KeepsRequestsThatFit) {
  for (const std::uint64_t triangles : {std::uint64_t{0}, std::uint64_t{5'000'000}}) {
    const IsosurfaceRequest request = request_for(triangles);
    EXPECT_EQ(within_budget(request, dataset(), noisy_surface), request);
  }
}

TEST(Budget, UsesTheLowestSufficientFloor) {
  for (const std::uint64_t triangles : {900'000U, 500'000U, 300'000U}) {
    const IsosurfaceRequest found = within_budget(request_for(triangles), dataset(), noisy_surface);
    EXPECT_EQ(found.topology_tolerance, 0);
    EXPECT_GT(found.thresholds.error_floor, 0);
    EXPECT_TRUE(fits(noisy_surface({found}), found));
    IsosurfaceRequest lower = found;
    lower.thresholds.error_floor /= 2;
    EXPECT_FALSE(fits(noisy_surface({lower}), lower)) << triangles;
  }
}

TEST(Budget, KeepsTheTopology) {
  for (const double tolerance : {0.0, 2.0}) {
    IsosurfaceRequest request = request_for(100);
    request.topology_tolerance = tolerance;
    const IsosurfaceRequest found = within_budget(request, dataset(), noisy_surface);
    EXPECT_EQ(found.topology_tolerance, tolerance);
    EXPECT_EQ(found.thresholds.error_floor, 256) << "as coarse as thresholds make it";
  }
}

TEST(Budget, LimitsBytes) {
  const IsosurfaceRequest found = within_budget(request_for(0, 500'000), dataset(), noisy_surface);
  EXPECT_LE(noisy_surface({found}).bytes, 500'000);
  EXPECT_GT(noisy_surface({found}).bytes, 250'000);
}

TEST(Budget, GivesTheSameResultInWorldUnits) {
  IsosurfaceRequest world = request_for(300'000);
  world.unit = ErrorUnit::kWorld;
  world.error = 0.25 * 0.5;
  const auto size_of = [](StepRequest step) {  // One voxel is half a world unit.
    step.request.error /= 0.5;
    step.request.thresholds.error_floor /= 0.5;
    return noisy_surface(step);
  };
  const IsosurfaceRequest voxels = within_budget(request_for(300'000), dataset(0.5), noisy_surface);
  EXPECT_DOUBLE_EQ(within_budget(world, dataset(0.5), size_of).thresholds.error_floor,
                   0.5 * voxels.thresholds.error_floor);
}

TEST(Budget, NeedsFewSizeEstimates) {
  int requested = 0;
  (void)within_budget(request_for(1), dataset(), [&requested](const StepRequest& step) {
    ++requested;
    return noisy_surface(step);
  });
  EXPECT_LE(requested, 10);
}

TEST(ErrorSchedule, IncreasesWithEveryLevel) {
  IsosurfaceRequest request = request_for(1);
  request.error = 0.3;
  const ErrorSchedule schedule(request, dataset());
  EXPECT_EQ(schedule.at(0), request);
  double size = noisy_surface({request}).triangles;
  double floor = request.error;
  for (int level = 1; level <= schedule.last(); ++level) {
    const double higher = schedule.at(level).thresholds.error_floor;
    EXPECT_GT(higher, floor) << "every level makes a difference";
    EXPECT_LE(higher, 1.2 * floor);
    floor = higher;
    EXPECT_LT(noisy_surface({schedule.at(level)}).triangles, size);
    size = noisy_surface({schedule.at(level)}).triangles;
  }
  EXPECT_EQ(floor, 256);
}

// A finer region, or a view, may need a floor below the error elsewhere.
TEST(ErrorSchedule, StartsAtTheLeastThresholdOfAMap) {
  IsosurfaceRequest request = request_for(1);
  request.error = 8;
  request.thresholds.regions = {{.shape = HalfSpaceShape{}, .threshold = 0.5}};
  EXPECT_LT(ErrorSchedule(request, dataset()).at(1).thresholds.error_floor, 0.6);
  request.thresholds.regions.clear();
  request.thresholds.view = ThresholdView{};
  EXPECT_LT(ErrorSchedule(request, dataset()).at(1).thresholds.error_floor, 0.1);
}

// Four levels are one octave.
TEST(ErrorSchedule, InterpolatesBetweenTooLargeAndFittingLevels) {
  EXPECT_EQ(next_level(TriedLevel{0, 0.85 * 16}, TriedLevel{20, 0.85 / 16}, 3, 40), 10);
  EXPECT_EQ(next_level(TriedLevel{0, 1.1}, TriedLevel{20, 0.01}, 3, 40), 1)
      << "nearest to the goal";
  EXPECT_EQ(next_level(TriedLevel{0, 100}, TriedLevel{2, 0}, 0, 40), 1) << "an empty surface";
}

TEST(ErrorSchedule, ExtrapolatesSizesAsPowersOfTheThreshold) {
  const TriedLevel fits = {40, 0.85 / 8};  // Three octaves too small.
  EXPECT_EQ(next_level(std::nullopt, fits, 0, 47), 28) << "not all the way down";
  EXPECT_EQ(next_level(std::nullopt, fits, 39, 47), 37);
  EXPECT_EQ(next_level(std::nullopt, fits, 33, 47), 33);
  EXPECT_EQ(next_level(std::nullopt, TriedLevel{1, 0.1}, 0, 47), 0);
  const TriedLevel is_too_large = {4, 0.85 * 8};
  EXPECT_EQ(next_level(is_too_large, std::nullopt, 5, 30), 7);
  EXPECT_EQ(next_level(is_too_large, std::nullopt, 12, 30), 12);
  EXPECT_EQ(next_level(is_too_large, std::nullopt, 30, 30), 30);
  EXPECT_EQ(next_level(TriedLevel{29, 50}, std::nullopt, 30, 30), 30);
}

TEST(ErrorSchedule, ExtrapolatesFromTriedSizes) {
  EXPECT_EQ(coarser_level(std::nullopt, {8, 2}, 40), 13);
  EXPECT_EQ(coarser_level(TriedLevel{4, 4}, {8, 2}, 40), 12) << "an octave of size in four levels";
  EXPECT_EQ(coarser_level(TriedLevel{4, 2.001}, {8, 2}, 40), 24) << "at most four octaves";
  EXPECT_EQ(coarser_level(TriedLevel{4, 4}, {8, 1.01}, 40), 9) << "and at least a level";
  EXPECT_EQ(coarser_level(TriedLevel{4, 4}, {8, 2}, 10), 10);
}

TEST(ErrorSchedule, ReturnsAFinerLevelForAnUnusedBudget) {
  EXPECT_EQ(finer_level({20, 0.25}), 8);
  EXPECT_EQ(finer_level({6, 0}), 0);
}

}  // namespace
}  // namespace multitetra
