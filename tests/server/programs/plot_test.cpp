// The plot of a dataset: its numbers and its drawing.
#include "server/programs/plot/dataset_plot.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "server/extraction/surface_extractor.hpp"
#include "server/programs/plot/svg.hpp"
#include "tests/support/prepared_fields.hpp"

namespace multitetra {
namespace {

using testing::prepared;
namespace fields = testing::fields;

std::size_t occurrences(const std::string& text, const std::string& words) {
  std::size_t count = 0;
  for (std::size_t at = text.find(words); at != std::string::npos; at = text.find(words, at + 1)) {
    ++count;
  }
  return count;
}

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

TEST(DatasetPlot, DrawsACurvePerErrorAndAMarkPerSuggestion) {
  const DatasetPtr dataset = prepared({"gyroid", fields::gyroid(40, 0.2, 8)});
  const SizeCurves curves =
      size_curves(SurfaceExtractor(dataset), even_isovalues(dataset->info, 8), {0.25, 1, 4});
  const std::string svg = dataset_plot(dataset->info, curves);
  EXPECT_EQ(occurrences(svg, "<polyline"), 3U);
  EXPECT_EQ(occurrences(svg, "<polygon"), 1U);
  EXPECT_EQ(occurrences(svg, "stroke-dasharray"), dataset->info.suggested_isovalues.size());
  for (const char* words : {"isovalue", "triangles of the surface", "samples in a bin", "1 voxel",
                            "0.25 voxels", "allowed error"}) {
    EXPECT_NE(svg.find(words), std::string::npos) << words;
  }
  EXPECT_EQ(occurrences(svg, "nan") + occurrences(svg, "inf"), 0U);
}

TEST(DatasetPlot, DrawsNoCurvesForAConstantDataset) {
  DatasetInfo info;
  info.name = "constant";
  info.dims = {2, 2, 2};
  info.min = info.max = 7;
  info.histogram = {.low = 7, .high = 7, .counts = {8}};
  const std::string svg = dataset_plot(info, {.isovalues = {}, .errors = {1}, .triangles = {{}}});
  EXPECT_EQ(occurrences(svg, "nan") + occurrences(svg, "inf"), 0U);
  EXPECT_NE(svg.find("</svg>"), std::string::npos);
}

TEST(Svg, EscapesForeignText) {
  Svg svg(10, 10);
  svg.text(1, 1, "<script>&\"\x01", {});
  const std::string file = svg.file("a < b");
  EXPECT_NE(file.find("&lt;script&gt;&amp;&quot;<"), std::string::npos);
  EXPECT_NE(file.find("<title>a &lt; b</title>"), std::string::npos);
  EXPECT_EQ(file.find('\x01'), std::string::npos);
}

}  // namespace
}  // namespace multitetra
