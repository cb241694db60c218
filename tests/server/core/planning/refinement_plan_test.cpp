#include "server/core/planning/refinement_plan.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace multitetra {
namespace {

DatasetInfo dataset(std::int32_t samples_a_side, double spacing = 1) {
  DatasetInfo info;
  info.dims = {samples_a_side, samples_a_side, samples_a_side};
  info.spacing = {spacing, spacing, spacing};
  info.grid_exponent = grid_exponent_for(info.dims, 0);
  return info;
}

// A surface of so many bytes at full resolution, of which a finest spacing f leaves f^-2.
struct Surface {
  double bytes = 4e6;
  double share_left = 1;  // By simplification.

  [[nodiscard]] StepSizes sizes() const {
    const auto size_at = [bytes = bytes, share_left = share_left](double finest) {
      const double size = bytes / (finest * finest);
      return SurfaceSize{.triangles = size, .bytes = share_left * size, .extracted = size};
    };
    return {.of = [=](const StepRequest& step) { return size_at(step.finest_spacing); },
            .rough = [=](const IsosurfaceRequest&) { return size_at(1); }};
  }
};

// The whole stream, as the server makes it.
std::vector<StepRequest> stream(const IsosurfaceRequest& request, const DatasetInfo& info,
                                const Surface& surface = {}, bool previews = true) {
  const StepSizes sizes = surface.sizes();
  std::vector<ShownStep> shown;
  std::vector<StepRequest> steps;
  for (;;) {
    const NextStep next = next_step(request, previews, shown, info, sizes);
    steps.push_back(next.step);
    if (next.is_final) return steps;
    shown.push_back({next.step, sizes.of(next.step).bytes});
    if (steps.size() > 10) throw std::runtime_error("the stream has no end");
  }
}

TEST(RefinementPlan, EndsWithExactlyTheRequest) {
  for (const double error : {0.0, 0.5, 3.0, 100.0}) {
    for (const bool previews : {false, true}) {
      const IsosurfaceRequest request{
          .isovalue = 3, .error = error, .topology_tolerance = 1, .lattice_resolution = 7};
      const auto steps = stream(request, dataset(129), {}, previews);
      EXPECT_EQ(steps.back(), (StepRequest{.request = request, .finest_spacing = 1}));
    }
  }
}

TEST(RefinementPlan, HasPreviewsThatFallTowardsTheRequest) {
  const auto steps = stream({.error = 0.5}, dataset(257));
  ASSERT_EQ(steps.size(), 3U);
  for (std::size_t i = 0; i + 1 < steps.size(); ++i) {
    EXPECT_GT(steps[i].request.thresholds.at_least, steps[i + 1].request.thresholds.at_least);
    EXPECT_GT(steps[i].request.topology_tolerance, steps[i + 1].request.topology_tolerance);
    EXPECT_GT(steps[i].finest_spacing, steps[i + 1].finest_spacing);
    EXPECT_EQ(steps[i].request.isovalue, steps.back().request.isovalue);
  }
}

TEST(RefinementPlan, HasNoPreviewUnlessAskedFor) {
  EXPECT_EQ(stream({.error = 0.5}, dataset(257), {}, false).size(), 1U);
}

// What is promised of the bytes, for surfaces of any size in grids of any size.
TEST(RefinementPlan, PreviewsKeepToTheirShares) {
  for (const std::int32_t side : {65, 129, 257, 513, 2049}) {
    for (const double bytes : {1e5, 1e6, 1e7, 1e8}) {
      SCOPED_TRACE(std::to_string(side) + ", " + std::to_string(bytes));
      const Surface surface{.bytes = bytes};
      const auto steps = stream({.error = 0.5}, dataset(side), surface);
      ASSERT_GE(steps.size(), 2U);
      double previews = 0;
      for (std::size_t i = 0; i + 1 < steps.size(); ++i) {
        const double size = surface.sizes().of(steps[i]).bytes;
        EXPECT_TRUE(i > 0 || size <= kFirstShare * bytes) << size;
        previews += size;
      }
      EXPECT_LE(previews, kPreviewsShare * bytes);
    }
  }
}

TEST(RefinementPlan, TheFirstNeedsNothingThatIsFinerThanTheSpectrum) {
  for (const std::int32_t side : {65, 129, 257, 513}) {
    EXPECT_GE(stream({.error = 0.5}, dataset(side)).front().finest_spacing, 8);
  }
}

TEST(RefinementPlan, IsCoarserForALargerSurface) {
  const auto small = stream({.error = 0.5}, dataset(513), {.bytes = 1e6});
  const auto large = stream({.error = 0.5}, dataset(513), {.bytes = 1e8});
  EXPECT_LT(small.front().finest_spacing, large.front().finest_spacing);
}

TEST(RefinementPlan, ASmallSurfaceComesAtOnce) {
  EXPECT_EQ(stream({.error = 0.5}, dataset(257), {.bytes = 1e4}).size(), 1U);
}

// It has few bytes, but takes its time.
TEST(RefinementPlan, ASurfaceThatIsSimplifiedToLittleHasPreviews) {
  const Surface surface{.bytes = 4e6, .share_left = 0.005};
  const auto steps = stream({.error = 0.5}, dataset(257), surface);
  ASSERT_EQ(steps.size(), 3U);
  const StepSizes sizes = surface.sizes();
  EXPECT_LE(sizes.of(steps[0]).bytes, kFirstShare * kLeastWhole);
  EXPECT_LE(sizes.of(steps[0]).bytes + sizes.of(steps[1]).bytes, kPreviewsShare * kLeastWhole);
}

TEST(RefinementPlan, HasNoPreviewThatASmallGridCannotShow) {
  EXPECT_EQ(stream({.error = 1}, dataset(9)).size(), 1U);
  EXPECT_EQ(stream({.error = 1}, dataset(33)).size(), 1U);
}

TEST(RefinementPlan, HasPreviewsAlsoWhereTheRequestItselfToleratesMuch) {
  const auto steps = stream({.error = 1, .topology_tolerance = 1e3}, dataset(257));
  ASSERT_EQ(steps.size(), 3U);
  for (const StepRequest& step : steps) EXPECT_EQ(step.request.topology_tolerance, 1e3);
}

TEST(RefinementPlan, HasFiniteErrorsHoweverLargeTheRequestIs) {
  for (const StepRequest& step : stream({.error = 1e308}, dataset(513))) {
    EXPECT_TRUE(std::isfinite(step.request.thresholds.at_least));
  }
}

TEST(RefinementPlan, MeansTheSameInVoxelsAndInWorldUnits) {
  const DatasetInfo info = dataset(257, 0.25);
  const auto voxels = stream({.error = 0.5, .unit = LengthUnit::kVoxel}, info);
  const auto world = stream({.error = 0.5 * 0.25, .unit = LengthUnit::kWorld}, info);
  ASSERT_EQ(voxels.size(), world.size());
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    EXPECT_DOUBLE_EQ(voxels[i].request.thresholds.at_least * 0.25,
                     world[i].request.thresholds.at_least);
  }
}

}  // namespace
}  // namespace multitetra
