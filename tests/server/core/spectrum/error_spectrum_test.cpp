// The error spectrum is never below the exact errors of single isovalues, and never far above.

#include <gtest/gtest.h>

#include <limits>

#include "server/core/errors/saturated_errors.hpp"
#include "server/core/framework/rounding.hpp"
#include "server/core/spectrum/detail/error_codes.hpp"
#include "server/core/spectrum/detail/spectrum_brick.hpp"
#include "tests/support/make_dataset.hpp"
#include "tests/support/prepared_fields.hpp"
#include "tests/support/volume_in_memory.hpp"

namespace multitetra::testing {
namespace {

// Calls `visit` for the points that the spectrum stores.
template <typename Visit>
void for_each_point(const SpectrumLayout& layout, const Visit& visit) {
  for (const SpectrumLayout::Level& level : layout.levels()) {
    const auto& [exponent, low, extent] = level.extent;
    for (std::int32_t z = low.z; z < low.z + extent.z; ++z) {
      for (std::int32_t y = low.y; y < low.y + extent.y; ++y) {
        for (std::int32_t x = low.x; x < low.x + extent.x; ++x) {
          if (((x | y | z) & 1) != 0) visit(DividingPoint((1 << exponent) * GridPoint{x, y, z}));
        }
      }
    }
  }
}

class ErrorSpectrumEveryField : public ::testing::TestWithParam<PreparedSetting> {};
INSTANTIATE_TEST_SUITE_P(Fields, ErrorSpectrumEveryField, ::testing::ValuesIn(prepared_settings()),
                         [](const auto& p) { return p.param.name; });

// Either errors are stored, or bounds follow from the ranges of cells.
class ErrorBoundsEveryField : public ::testing::TestWithParam<PreparedSetting> {};
INSTANTIATE_TEST_SUITE_P(Fields, ErrorBoundsEveryField, ::testing::ValuesIn(prepared_settings()),
                         [](const auto& p) { return p.param.name; });
INSTANTIATE_TEST_SUITE_P(FieldsWithoutErrors, ErrorBoundsEveryField,
                         ::testing::ValuesIn(settings_without_errors()),
                         [](const auto& p) { return p.param.name; });

TEST_P(ErrorBoundsEveryField, NeverFallBelowTheExactErrors) {
  const Field field(GetParam().volume, GetParam().outside, GetParam().margin);
  for (const int bins : {7, 64, 256}) {
    const DatasetPtr dataset = prepared(GetParam(), bins);
    for (const double isovalue : isovalues_of(*dataset)) {
      for (const ErrorMeasure measure : {ErrorMeasure::kCertified, ErrorMeasure::kPaper}) {
        for (const TopologyRule rule : {TopologyRule::kExact, TopologyRule::kPaper}) {
          SCOPED_TRACE(::testing::Message() << bins << " bins, isovalue " << isovalue << ", "
                                            << name(measure) << ", rule " << name(rule));
          const SaturatedErrors exact(field, isovalue, measure, rule);
          const SpectrumErrors spectrum(*dataset, isovalue, measure, rule);
          std::size_t smaller = 0;
          for_each_point(dataset->spectrum.layout, [&](const DividingPoint& point) {
            const ErrorBound is = spectrum.bound(point);
            const ErrorBound least = exact.bound(point);
            smaller += is.error < least.error || is.flip_spacing < least.flip_spacing ? 1U : 0U;
          });
          EXPECT_EQ(smaller, 0U);
        }
      }
    }
  }
}

TEST_P(ErrorBoundsEveryField, NeverDecreaseFromChildrenToParents) {
  const DatasetPtr dataset = prepared(GetParam());
  const Grid grid = grid_of(dataset->info);
  for (const double isovalue : isovalues_of(*dataset)) {
    const SpectrumErrors spectrum(*dataset, isovalue, ErrorMeasure::kCertified,
                                  TopologyRule::kExact);
    std::size_t shrinking = 0;
    for_each_point(dataset->spectrum.layout, [&](const DividingPoint& point) {
      const ErrorBound child = spectrum.bound(point);
      const PointList<4> parents = point.parents(grid);
      for (const GridPoint p : parents) {
        const ErrorBound parent = spectrum.bound(DividingPoint(p));
        shrinking += parent.error < child.error || parent.flip_spacing < child.flip_spacing;
      }
    });
    EXPECT_EQ(shrinking, 0U) << isovalue;
  }
}

TEST_P(ErrorSpectrumEveryField, IsIndependentOfMemory) {
  const DatasetPtr ample = prepared(GetParam());
  const DatasetPtr scarce =
      make_dataset(*source_of(GetParam().volume), {.name = GetParam().name,
                                                   .outside = GetParam().outside,
                                                   .margin = GetParam().margin,
                                                   .slab_bytes = 1,
                                                   .column_bytes = 1});
  for (std::size_t i = 0; i < ample->spectrum.layout.size(); ++i) {
    const auto is = scarce->spectrum.bricks->brick(i);
    const auto expected = ample->spectrum.bricks->brick(i);
    EXPECT_TRUE(std::equal(is.begin(), is.end(), expected.begin(), expected.end())) << i;
  }
}

TEST(ErrorSpectrum, IsEmptyOutsideTheValueRange) {
  const DatasetPtr dataset = prepared({"gyroid", fields::gyroid(33, 0.3, 1)});
  for (const double isovalue : {-100.0, dataset->info.min - 1e-9, dataset->info.max, 1e300}) {
    const SpectrumErrors spectrum(*dataset, isovalue, ErrorMeasure::kCertified,
                                  TopologyRule::kExact);
    for_each_point(dataset->spectrum.layout, [&](const DividingPoint& point) {
      ASSERT_EQ(spectrum.bound(point).error, 0) << isovalue;
    });
  }
}

TEST(ErrorSpectrum, IsEmptyForAConstantField) {
  const DatasetPtr dataset = prepared(
      {"constant", fields::sampled<float>({20, 20, 20}, [](int, int, int) { return 3.0; })});
  EXPECT_EQ(dataset->spectrum.bins.count(), 0);
  const SpectrumErrors spectrum(*dataset, 3, ErrorMeasure::kPaper, TopologyRule::kPaper);
  EXPECT_EQ(spectrum.bound(DividingPoint({8, 8, 8})).error, 0);
}

// ---- bins

TEST(IsovalueBins, DivideIntegersIntoEqualWidths) {
  DatasetInfo info;
  info.type = SampleType::kI16;
  info.min = -1024;
  info.max = 3063;
  const IsovalueBins bins = IsovalueBins::for_values(info, {}, 64);
  EXPECT_LE(bins.count(), 64);
  EXPECT_EQ(bins.low(0), -1024);
  EXPECT_EQ(bins.high(bins.count() - 1), 3063);
  for (int bin = 1; bin + 1 < bins.count(); ++bin) {
    EXPECT_EQ(bins.low(bin), std::floor(bins.low(bin)));
    EXPECT_EQ(bins.high(bin) - bins.low(bin), bins.high(0) - bins.low(0));
  }
}

TEST(IsovalueBins, HaveOneBinPerValueForFewIntegers) {
  DatasetInfo info;
  info.type = SampleType::kU8;
  info.max = 29;
  const IsovalueBins bins = IsovalueBins::for_values(info, {}, 64);
  EXPECT_EQ(bins.count(), 58);
  EXPECT_EQ(bins.low(1), 0.5F);
}

TEST(IsovalueBins, DivideDistinctFloatsEqually) {
  DatasetInfo info;
  info.type = SampleType::kF32;
  info.max = 1000;
  std::vector<float> values;
  for (int i = 0; i < 1000; ++i) values.push_back(static_cast<float>(i) * 1e-4F);
  values.push_back(1000);
  const IsovalueBins bins = IsovalueBins::for_values(info, values, 64);
  EXPECT_GE(bins.count(), 60);
  EXPECT_LT(bins.low(bins.count() - 1), 0.2F);
}

TEST(IsovalueBins, FindEveryValueBetweenItsEdges) {
  for (const PreparedSetting& setting : prepared_settings()) {
    const DatasetPtr dataset = prepared(setting);
    const IsovalueBins& bins = dataset->spectrum.bins;
    for (int i = 0; i <= 1000; ++i) {
      const auto value = static_cast<float>(
          static_cast<double>(bins.edges().front()) +
          (static_cast<double>(bins.edges().back()) - static_cast<double>(bins.edges().front())) *
              i / 1000);
      const int bin = bins.first_from(value);
      ASSERT_LE(bins.low(bin), value) << setting.name;
      if (bin + 1 < bins.count()) {
        ASSERT_GT(bins.high(bin), value) << setting.name;
      }
      if (i == 0) continue;
      ASSERT_LT(bins.low(bins.last_below(value)), value) << setting.name;
      if (i < 1000) {
        ASSERT_EQ(bins.bin_of(static_cast<double>(value)), bin) << setting.name;
      }
    }
    // As in a file whose samples contradict them.
    EXPECT_EQ(bins.first_from(-1e30F), 0) << setting.name;
    EXPECT_EQ(bins.first_from(1e30F), bins.count() - 1) << setting.name;
  }
}

// ---- codes and bricks

TEST(ErrorCodes, RoundUpSlightly) {
  const ErrorCodes& codes = error_codes();
  EXPECT_EQ(codes.code(0), 0);
  EXPECT_EQ(codes.value(0), 0);
  float error = std::numeric_limits<float>::denorm_min();
  for (; error < 1000; error = error * 1.0173F + std::numeric_limits<float>::denorm_min()) {
    const float value = codes.value(codes.code(error));
    ASSERT_GE(value, error);
    if (error > 0.02F && error < 900) {
      ASSERT_LT(value, error * 1.054F);
    }
  }
  EXPECT_EQ(codes.code(1e30F), 255);
  EXPECT_EQ(codes.code(std::numeric_limits<float>::max()), 255);
  EXPECT_EQ(codes.value(255), std::numeric_limits<float>::infinity());
}

TEST(Rounding, NeverCrossesTheValue) {
  for (const double value : {0.0, 1e-300, 0.1, 1.0, 1.0 / 3, 16777217.0, 3e38}) {
    EXPECT_GE(static_cast<double>(rounded_up(value)), value);
    for (const double signed_value : {value, -value}) {
      const float down = rounded_down(signed_value);
      EXPECT_LE(static_cast<double>(down), signed_value);
      EXPECT_GT(static_cast<double>(std::nextafter(down, std::numeric_limits<float>::infinity())),
                signed_value);
    }
  }
  EXPECT_EQ(rounded_down(1e300), std::numeric_limits<float>::max());
  EXPECT_EQ(rounded_down(-1e300), -std::numeric_limits<float>::infinity());
}

TEST(SpectrumBrick, ReportsDamageOrReturnsOtherCodes) {
  const DatasetPtr dataset = prepared({"noise", fields::noise({33, 33, 33}, 2)});
  const auto whole = dataset->spectrum.bricks->brick(0);
  ASSERT_FALSE(whole.empty());
  std::vector<std::byte> bytes(whole.begin(), whole.end());
  for (std::size_t size = 0; size < bytes.size(); size += 1 + size / 7) {
    for (const int bin : {0, 20, 63}) (void)decode_plane(std::span(bytes).first(size), bin);
  }
  std::mt19937_64 random(1);
  std::size_t errors = 0;
  for (int i = 0; i < 2000; ++i) {
    const std::size_t at = i < 300 ? static_cast<std::size_t>(i) : random() % bytes.size();
    const std::byte before = bytes[at];
    bytes[at] ^= static_cast<std::byte>(1U << random() % 8);
    for (int bin = 0; bin < 64; ++bin) errors += decode_plane(bytes, bin) ? 0U : 1U;
    bytes[at] = before;
  }
  EXPECT_GT(errors, 0U);
}

}  // namespace
}  // namespace multitetra::testing
