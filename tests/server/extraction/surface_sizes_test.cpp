// Sizes that are estimated before extraction.
#include "server/extraction/surface_sizes.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "common/base/in_parallel.hpp"
#include "server/extraction/detail/simplified_surface.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "server/service/caching_surface_provider.hpp"
#include "server/stream/stream_plan.hpp"
#include "tests/support/prepared_fields.hpp"
#include "tests/support/sweep.hpp"

namespace multitetra {
namespace {

using testing::prepared;
using testing::PreparedSetting;
namespace fields = testing::fields;

const std::vector<DatasetPtr>& datasets() {
  static const std::vector<DatasetPtr> all = {
      prepared({"noisy_gyroid", fields::gyroid(90, 0.2, 8)}),
      prepared({"ball", fields::ball({70, 60, 80}, 25)}),
      prepared({"noise", fields::noise({50, 60, 70}, 3)}),
      prepared({"stretched", fields::gyroid(60, 0.05, 9, {1, 1.3, 2}), 0.0, 1})};
  return all;
}

// The size of the encoded step.
SurfaceSize size_of(const DatasetPtr& dataset, const StepRequest& step) {
  const CachingSurfaceProvider source(std::make_shared<const SurfaceExtractor>(dataset));
  return size_of(source.make(step, {}));
}

double triangles_of(const DatasetPtr& dataset, const StepRequest& step) {
  return size_of(dataset, step).triangles;
}

// The longest chain counts no join of pieces twice, and every join takes time.
TEST(SimplificationWork, IsAtLeastItsLongestChain) {
  const DatasetPtr dataset = prepared({"noisy_gyroid", fields::gyroid(90, 0.2, 8)});
  const SurfaceExtractor extractor(dataset);
  TiledMesh surface = extractor.extract({.request = {.isovalue = 0, .error = 0.1}});
  const SimplificationOptions how{.lattice_step = {0.03125, 0.03125, 0.03125}, .max_distance = 0.5};
  const int root = dataset->info.grid_exponent;
  SurfaceSimplifier simplifier(how.lattice_step, root);
  for (TileMesh& tile : surface.tiles) simplifier.add(std::move(tile), how, {});
  const SimplificationWork work = simplifier.simplify(how, {});
  EXPECT_GT(work.longest_chain, 0);
  EXPECT_GE(work.seconds, work.longest_chain);
  EXPECT_EQ(SurfaceSimplifier(how.lattice_step, root).simplify(how, {}).seconds, 0);
}

TEST(SurfaceSizes, AreNearTheRealSizes) {
  for (const DatasetPtr& dataset : datasets()) {
    const SurfaceExtractor extractor(dataset);
    const SizeEstimates sizes = surface_sizes(extractor, {}, SizeAccuracy::kAccurate);
    const double isovalue = dataset->info.min + 0.45 * (dataset->info.max - dataset->info.min);
    for (const double error : {0.0, 0.5, 2.0}) {
      for (const std::int32_t finest : {1, 4, 8}) {
        StepRequest step{.request = {.isovalue = isovalue, .error = error},
                         .finest_spacing = finest};
        if (finest > 1) step.request.topology_tolerance = finest / 2;
        SCOPED_TRACE(dataset->info.name + ", error " + std::to_string(error) + ", finest " +
                     std::to_string(finest));
        const double real = triangles_of(dataset, step);
        const double estimate = sizes.of(step).triangles;
        EXPECT_LE(std::abs(estimate - real), 0.3 * real + 100) << estimate << " for " << real;
      }
    }
  }
}

// The size is extrapolated from a few simplified blocks: more accurate than the rough estimate,
// less than that of unsimplified surfaces.
TEST(SurfaceSizes, AreNearTheRealSizesIfSimplified) {
  for (const DatasetPtr& dataset : datasets()) {
    const SurfaceExtractor extractor(dataset);
    const SizeEstimates sizes = surface_sizes(extractor, {}, SizeAccuracy::kAccurate);
    const SizeEstimates quickly = surface_sizes(extractor, {}, SizeAccuracy::kQuick);
    const double isovalue = dataset->info.min + 0.45 * (dataset->info.max - dataset->info.min);
    for (const double error : testing::sweep<std::vector<double>>({0.5}, {0.0, 0.25, 1.0})) {
      SCOPED_TRACE(dataset->info.name + ", error " + std::to_string(error));
      const StepRequest step{.request = {.isovalue = isovalue, .error = error, .simplify = true}};
      const SurfaceSize real = size_of(dataset, step);
      const SurfaceSize estimate = sizes.of(step);
      EXPECT_LE(estimate.triangles, 2 * real.triangles + 100);
      EXPECT_GE(estimate.triangles, 0.5 * real.triangles - 100);
      EXPECT_LE(estimate.bytes, 2 * real.bytes + 500);
      EXPECT_GE(estimate.bytes, 0.5 * real.bytes - 500);
      EXPECT_GE(estimate.extracted, 0.7 * real.triangles);
      // Quick estimates let a server reject requests far above its limit.
      const SurfaceSize quick = quickly.of(step);
      EXPECT_LE(quick.triangles, 3 * real.triangles + 100);
      EXPECT_GE(quick.triangles, 0.2 * real.triangles - 100);
      EXPECT_LE(quick.bytes, 3 * real.bytes + 500);
    }
  }
}

TEST(SurfaceSizes, AreZeroForAnEmptySurface) {
  const DatasetPtr dataset = datasets().front();
  EXPECT_EQ(surface_sizes(SurfaceExtractor(dataset)).of({.request = {.isovalue = 1e6}}).triangles,
            0);
  EXPECT_EQ(surface_sizes(SurfaceExtractor(dataset)).rough({.isovalue = 1e6}).bytes, 0);
}

TEST(SurfaceSizes, ExistForGridsWithoutASpectrum) {
  const DatasetPtr dataset = prepared({"tiny", fields::ball({8, 7, 9}, 3)});
  const StepRequest step{.request = {.isovalue = 0}};
  EXPECT_EQ(surface_sizes(SurfaceExtractor(dataset)).of(step).triangles,
            triangles_of(dataset, step));
}

TEST(SurfaceSizes, AreDeterministic) {
  const DatasetPtr dataset = datasets().front();
  const StepRequest step{.request = {.isovalue = 0.1, .error = 0.5}};
  const double first = surface_sizes(SurfaceExtractor(dataset)).of(step).triangles;
  for (int i = 0; i < 3; ++i)
    EXPECT_EQ(surface_sizes(SurfaceExtractor(dataset)).of(step).triangles, first);
}

// Small surfaces are simplified as a whole, not extrapolated.
TEST(SurfaceSizes, AreExactForSmallSimplifiedSurfaces) {
  const DatasetPtr dataset = prepared({"ball", fields::ball({40, 40, 40}, 12)});
  const SurfaceExtractor extractor(dataset);
  const StepRequest step{.request = {.isovalue = 0, .error = 0.5, .simplify = true}};
  const SurfaceSize estimate = surface_sizes(extractor, {}, SizeAccuracy::kAccurate).of(step);
  EXPECT_EQ(estimate.triangles, size_of(dataset, step).triangles);
  EXPECT_EQ(estimate.bytes, size_of(dataset, step).bytes);
}

// The regions of the map determine the size, not the error outside them.
TEST(SurfaceSizes, AreRoughlyRightForAnyMap) {
  const DatasetPtr dataset = datasets().front();
  const SurfaceExtractor extractor(dataset);
  const SizeEstimates sizes = surface_sizes(extractor);
  const IsosurfaceRequest fine{.isovalue = 0.1, .error = 0.5};
  const double everywhere = sizes.rough(fine).triangles;
  IsosurfaceRequest same{.isovalue = 0.1, .error = 1000};
  same.thresholds.regions = {
      {.shape = BoxShape{.low = {-10, -10, -10}, .high = {200, 200, 200}}, .threshold = 0.5}};
  EXPECT_EQ(sizes.rough(same).triangles, everywhere);
  same.thresholds.regions.clear();
  same.thresholds.view = ThresholdView{
      .eye = {-1e6, 0, 0}, .field_of_view = 90, .height_pixels = 2e6, .tolerance_pixels = 0.5};
  EXPECT_NEAR(sizes.rough(same).triangles, everywhere, 0.01 * everywhere);
  IsosurfaceRequest half = fine;
  half.thresholds.regions = {
      {.shape = HalfSpaceShape{.normal = {1, 0, 0}, .offset = 45}, .threshold = 1000}};
  EXPECT_LT(sizes.rough(half).triangles, 0.8 * everywhere);
  EXPECT_GT(sizes.rough(half).triangles, 0.4 * everywhere);
}

// Small regions with small thresholds contain most, or a large part, of the triangles.
class SizesUnderMaps : public ::testing::Test {
 protected:
  [[nodiscard]] static StepRequest allowing(double error, const BoxShape& fine) {
    StepRequest step{.request = {.isovalue = 0.1, .error = error, .simplify = true}};
    step.request.thresholds = {.coordinates = CoordinateSystem::kIndex,
                               .regions = {{.shape = fine, .threshold = 0.25}}};
    return step;
  }
  void expect_near_the_real_ones(const StepRequest& step) const {
    const SurfaceSize real = size_of(dataset_, step);
    const SurfaceSize estimate = surface_sizes(extractor_, {}, SizeAccuracy::kAccurate).of(step);
    EXPECT_LE(estimate.triangles, 2 * real.triangles);
    EXPECT_GE(estimate.triangles, 0.5 * real.triangles);
    EXPECT_LE(estimate.bytes, 2 * real.bytes);
    EXPECT_GE(estimate.bytes, 0.5 * real.bytes);
    const SurfaceSize quick = surface_sizes(extractor_, {}, SizeAccuracy::kQuick).of(step);
    EXPECT_LE(quick.triangles, 3 * real.triangles);
    EXPECT_GE(quick.triangles, 0.3 * real.triangles);
  }

  DatasetPtr dataset_ = prepared({"gyroid", fields::gyroid(120, 0.1, 45)});
  SurfaceExtractor extractor_{dataset_};
};

TEST_F(SizesUnderMaps, EstimateASmallFineBox) {
  for (const double place : {4.0, 58.0, 100.0}) {
    SCOPED_TRACE(place);
    expect_near_the_real_ones(
        allowing(8, {.low = {place, place, place}, .high = {place + 4, place + 4, place + 4}}));
  }
}

TEST_F(SizesUnderMaps, EstimateAFineHalf) {
  expect_near_the_real_ones(allowing(4, {.low = {-1, -1, -1}, .high = {120, 120, 60}}));
  expect_near_the_real_ones(allowing(4, {.low = {60, -1, -1}, .high = {120, 120, 120}}));
}

TEST_F(SizesUnderMaps, EstimateAView) {
  StepRequest step{.request = {.isovalue = 0.1, .error = 0.25, .simplify = true}};
  step.request.thresholds = {
      .coordinates = CoordinateSystem::kIndex,
      .view = ThresholdView{
          .eye = {60, 60, -20}, .field_of_view = 45, .height_pixels = 800, .tolerance_pixels = 10}};
  expect_near_the_real_ones(step);
}

TEST(SurfaceSizes, StopOnRequest) {
  const DatasetPtr dataset = datasets().front();
  const SurfaceExtractor extractor(dataset);
  std::stop_source stop;
  stop.request_stop();
  for (const SizeAccuracy accuracy : {SizeAccuracy::kQuick, SizeAccuracy::kAccurate}) {
    const SizeEstimates sizes = surface_sizes(extractor, stop.get_token(), accuracy);
    const IsosurfaceRequest request{.isovalue = 0.1};
    EXPECT_THROW((void)sizes.rough(request), Cancelled);
    EXPECT_THROW((void)sizes.of({.request = request}), Cancelled);
    EXPECT_THROW((void)sizes.of({.request = request, .finest_spacing = 8}), Cancelled);
  }
}

}  // namespace
}  // namespace multitetra
