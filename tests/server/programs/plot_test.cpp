// The plot of a dataset: its numbers and its drawing.
#include "server/programs/plot/dataset_plot.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "server/extraction/surface_extractor.hpp"
#include "tests/support/prepared_fields.hpp"

namespace multitetra {
namespace {

using testing::prepared;
namespace fields = testing::fields;

double triangles_of(const SurfaceExtractor& extractor, double isovalue, double error,
                    bool simplify = false) {
  double triangles = 0;
  const StepRequest step = {
      .request = {.isovalue = isovalue, .error = error, .simplify = simplify}};
  for (const TileMesh& tile : extractor.extract(step).tiles) {
    triangles += static_cast<double>(tile.mesh.triangles.size());
  }
  return triangles;
}

TEST(SizeCurves, AreNearTheRealSizes) {
  const DatasetPtr dataset = prepared({"noisy_gyroid", fields::gyroid(60, 0.2, 8)});
  const SurfaceExtractor extractor(dataset);
  const std::vector<double> errors = {0.25, 1, 4};
  const SizeCurves curves = size_curves(extractor, even_isovalues(dataset->info, 3), errors);
  ASSERT_EQ(curves.isovalues.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < errors.size(); ++j) {
      const double real = triangles_of(extractor, curves.isovalues[i], errors[j]);
      EXPECT_NEAR(curves.triangles[j][i], real, 0.2 * real + 100);
    }
  }
}

TEST(SizeCurves, AreNearTheRealSizesIfSimplified) {
  const DatasetPtr dataset = prepared({"noisy_gyroid", fields::gyroid(60, 0.2, 8)});
  const SurfaceExtractor extractor(dataset);
  const std::vector<double> errors = {0.25, 1};
  const SizeCurves curves =
      size_curves(extractor, even_isovalues(dataset->info, 3), errors, {.simplify = true});
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < errors.size(); ++j) {
      const double real = triangles_of(extractor, curves.isovalues[i], errors[j], true);
      EXPECT_NEAR(curves.triangles[j][i], real, 0.5 * real + 100);
    }
  }
}

TEST(SizeCurves, DecreaseWithTheError) {
  const DatasetPtr dataset = prepared({"noisy_gyroid", fields::gyroid(60, 0.2, 8)});
  for (const bool simplify : {false, true}) {
    const SizeCurves curves =
        size_curves(SurfaceExtractor(dataset), even_isovalues(dataset->info, simplify ? 2 : 5),
                    {0, 0.5, 2, 8}, {.cubes = 1'000'000, .simplify = simplify});
    for (std::size_t j = 1; j < curves.errors.size(); ++j) {
      for (std::size_t i = 0; i < curves.isovalues.size(); ++i) {
        EXPECT_LE(curves.triangles[j][i], curves.triangles[j - 1][i]);
      }
    }
  }
}

TEST(SizeCurves, ExistForGridsWithoutASpectrum) {
  const DatasetPtr dataset = prepared({"ball", fields::ball({7, 8, 6}, 3)});
  const SizeCurves curves =
      size_curves(SurfaceExtractor(dataset), even_isovalues(dataset->info, 4), {0});
  EXPECT_GT(*std::max_element(curves.triangles[0].begin(), curves.triangles[0].end()), 10);
}

TEST(SpreadIsovalues, AreUniqueAndBetweenIntegers) {
  DatasetInfo info;
  info.max = 4;
  EXPECT_EQ(even_isovalues(info, 64), (std::vector<double>{0.5, 1.5, 2.5, 3.5}));
  info.type = SampleType::kF32;
  EXPECT_EQ(even_isovalues(info, 4), (std::vector<double>{0.5, 1.5, 2.5, 3.5}));
  info.max = info.min;
  EXPECT_TRUE(even_isovalues(info, 4).empty());
}

Picture plot_of(const DatasetInfo& info, const SizeCurves& curves) {
  Picture picture{.width = kPlotWidth,
                  .height = kPlotHeight,
                  .pixels = std::vector<Pixel>(std::size_t{kPlotWidth} * kPlotHeight,
                                               Pixel{255, 255, 255, 255})};
  Canvas canvas(picture);
  draw_dataset_plot(canvas, info, curves);
  return picture;
}

std::ptrdiff_t pixels_of(const Picture& picture, Rgb color) {
  return std::ranges::count(picture.pixels, Pixel{color[0], color[1], color[2], 255});
}

constexpr Rgb kFirstCurve = {59, 31, 107};
constexpr Rgb kThirdCurve = {31, 127, 134};
constexpr Rgb kFourthCurve = {58, 166, 85};
constexpr Rgb kSamples = {143, 166, 189};

TEST(DatasetPlot, DrawsACurvePerErrorAndAMarkPerSuggestion) {
  const DatasetPtr dataset = prepared({"gyroid", fields::gyroid(40, 0.2, 8)});
  const SizeCurves curves =
      size_curves(SurfaceExtractor(dataset), even_isovalues(dataset->info, 8), {0.25, 1, 4});
  const Picture plot = plot_of(dataset->info, curves);
  EXPECT_GT(pixels_of(plot, kSamples), 1000);
  EXPECT_GT(pixels_of(plot, kFirstCurve), 50);
  EXPECT_GT(pixels_of(plot, kThirdCurve), 50);
  EXPECT_EQ(pixels_of(plot, kFourthCurve), 0);
  DatasetInfo bare = dataset->info;
  bare.suggested_isovalues.clear();
  EXPECT_NE(plot_of(bare, curves).pixels, plot.pixels);
}

TEST(DatasetPlot, DrawsNoCurvesForAConstantDataset) {
  DatasetInfo info;
  info.name = "constant";
  info.dims = {2, 2, 2};
  info.min = info.max = 7;
  info.histogram = {.low = 7, .high = 7, .counts = {8}};
  const Picture plot = plot_of(info, {.isovalues = {}, .errors = {1}, .triangles = {{}}});
  EXPECT_GT(pixels_of(plot, {255, 255, 255}), kPlotWidth * kPlotHeight / 2);
}

}  // namespace
}  // namespace multitetra
