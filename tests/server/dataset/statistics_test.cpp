#include "server/dataset/detail/statistics.hpp"

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "server/dataset/detail/preferred_isovalues.hpp"
#include "server/dataset/detail/statistics_builder.hpp"
#include "server/dataset/detail/suggested_isovalues.hpp"
#include "server/volume/generators/generators.hpp"

namespace multitetra {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

Volume row_of(Samples samples) {
  const auto size = std::visit([](const auto& values) { return values.size(); }, samples);
  Volume volume;
  volume.dims = {static_cast<std::int32_t>(size), 1, 1};
  volume.samples = std::move(samples);
  return volume;
}

std::uint64_t total(const Histogram& histogram) {
  return std::accumulate(histogram.counts.begin(), histogram.counts.end(), std::uint64_t{0});
}

TEST(Statistics, HaveABinPerValueForSmallIntegerRanges) {
  const SampleStatistics facts = statistics(row_of(std::vector<std::int16_t>{-3, -3, -1, 2, 2, 2}));
  EXPECT_EQ(facts.min, -3);
  EXPECT_EQ(facts.max, 2);
  EXPECT_EQ(facts.void_samples, 0u);
  EXPECT_EQ(facts.histogram, (Histogram{-3.5, 2.5, {2, 0, 1, 0, 0, 3}}));
}

TEST(Statistics, PutBinEdgesBetweenIntegersForLargeRanges) {
  std::vector<std::uint16_t> samples(1000);
  std::iota(samples.begin(), samples.end(), std::uint16_t{100});
  const Histogram histogram = statistics(row_of(samples)).histogram;
  EXPECT_EQ(histogram.low, 99.5);
  EXPECT_EQ(histogram.high, 1099.5);  // 250 bins of 4 values.
  EXPECT_EQ(histogram.counts, std::vector<std::uint64_t>(250, 4));
}

TEST(Statistics, CountExtremesOfEveryIntegerType) {
  const auto check = [](auto lowest, auto highest) {
    using Sample = decltype(lowest);
    const SampleStatistics facts = statistics(row_of(std::vector<Sample>{highest, lowest}));
    EXPECT_EQ(facts.min, lowest);
    EXPECT_EQ(facts.max, highest);
    EXPECT_EQ(facts.histogram.counts.size(), 256u);
    EXPECT_EQ(facts.histogram.counts.front(), 1u);
    EXPECT_EQ(facts.histogram.counts.back(), 1u);
  };
  check(std::uint8_t{0}, std::uint8_t{255});
  check(std::int8_t{-128}, std::int8_t{127});
  check(std::uint16_t{0}, std::uint16_t{65535});
  check(std::int16_t{-32768}, std::int16_t{32767});
}

TEST(Statistics, CountNanOnlyAsVoid) {
  const SampleStatistics facts =
      statistics(row_of(std::vector<float>{kNan, -1.0F, kNan, 3.0F, 0.5F}));
  EXPECT_EQ(facts.min, -1);
  EXPECT_EQ(facts.max, 3);
  EXPECT_EQ(facts.void_samples, 2u);
  EXPECT_EQ(facts.histogram.low, -1);
  EXPECT_EQ(facts.histogram.high, 3);
  EXPECT_EQ(facts.histogram.counts.size(), 256u);
  EXPECT_EQ(facts.histogram.counts.back(), 1u);
  EXPECT_EQ(total(facts.histogram), 3u);
}

TEST(Statistics, HaveOneBinAndNoSuggestionForAConstantOrVoidVolume) {
  const SampleStatistics equal = statistics(row_of(std::vector<float>(5, 2.0F)));
  EXPECT_EQ(equal.histogram, (Histogram{1.5, 2.5, {5}}));
  EXPECT_TRUE(equal.suggested_isovalues.empty());
  const SampleStatistics none = statistics(row_of(std::vector<float>(5, kNan)));
  EXPECT_EQ(none.void_samples, 5u);
  EXPECT_EQ(none.min, 0);
  EXPECT_EQ(none.histogram, (Histogram{-0.5, 0.5, {0}}));
  EXPECT_TRUE(statistics(row_of(std::vector<std::uint8_t>(5, 9))).suggested_isovalues.empty());
}

TEST(Statistics, RejectInfiniteSamples) {
  const float infinity = std::numeric_limits<float>::infinity();
  EXPECT_THROW((void)statistics(row_of(std::vector<float>{1, infinity})), std::invalid_argument);
  EXPECT_THROW((void)statistics(row_of(std::vector<float>{-infinity, 1})), std::invalid_argument);
  EXPECT_THROW((void)statistics(row_of(std::vector<float>{infinity})), std::invalid_argument);
}

TEST(Statistics, AreIndependentOfThreadCount) {
  // Larger than several work items.
  const Volume volume = generate(GeneratorKind::kGyroid, {.size = 150, .noise = 0.1});
  const SampleStatistics many = statistics(volume);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const SampleStatistics single = statistics(volume);
  EXPECT_EQ(single.min, many.min);
  EXPECT_EQ(single.max, many.max);
  EXPECT_EQ(single.histogram, many.histogram);
  EXPECT_EQ(total(many.histogram), volume.size());
}

// ---- slab by slab

// Returns the samples begin ... end - 1.
Samples part_of(const Samples& samples, std::size_t begin, std::size_t end) {
  return std::visit(
      [&](const auto& values) {
        return Samples(
            std::decay_t<decltype(values)>(values.begin() + static_cast<std::ptrdiff_t>(begin),
                                           values.begin() + static_cast<std::ptrdiff_t>(end)));
      },
      samples);
}

// Returns the builder after all passes over `samples`, in slabs of `slab` samples, last slab first.
SampleStatisticsBuilder built(const Samples& samples, std::size_t size, std::size_t slab) {
  SampleStatisticsBuilder builder(static_cast<SampleType>(samples.index()));
  const auto pass = [&](auto add) {
    for (std::size_t end = size; end > 0; end -= std::min(slab, end)) {
      add(part_of(samples, end - std::min(slab, end), end));
    }
  };
  pass([&](const Samples& part) { builder.add(part); });
  if (builder.needs_second_pass()) {
    pass([&](const Samples& part) { builder.add_second_pass(std::get<std::vector<float>>(part)); });
  }
  return builder;
}

TEST(SampleStatisticsBuilder, IsIndependentOfSlabSizes) {
  for (const GeneratorKind kind : {GeneratorKind::kHead, GeneratorKind::kGyroid}) {
    Volume volume = generate(kind, {.size = 30, .noise = 0.1});
    if (auto* floats = std::get_if<std::vector<float>>(&volume.samples)) (*floats)[77] = kNan;
    const SampleStatistics expected = statistics(volume);
    for (const std::size_t slab : {std::size_t{900}, std::size_t{1234}, volume.size()}) {
      const SampleStatistics facts = built(volume.samples, volume.size(), slab).finish();
      EXPECT_EQ(facts.min, expected.min);
      EXPECT_EQ(facts.max, expected.max);
      EXPECT_EQ(facts.void_samples, expected.void_samples);
      EXPECT_EQ(facts.histogram, expected.histogram);
      EXPECT_EQ(facts.suggested_isovalues, expected.suggested_isovalues);
    }
  }
}

TEST(SampleStatisticsBuilder, NeedsASecondPassOnlyForDifferingFloats) {
  const auto needs = [](const Samples& samples) {
    SampleStatisticsBuilder builder(static_cast<SampleType>(samples.index()));
    builder.add(samples);
    return builder.needs_second_pass();
  };
  EXPECT_FALSE(needs(std::vector<std::uint16_t>{1, 2, 3}));
  EXPECT_FALSE(needs(std::vector<float>{2, 2, kNan}));
  EXPECT_FALSE(needs(std::vector<float>{0.0F, -0.0F}));
  EXPECT_FALSE(needs(std::vector<float>{kNan, kNan}));
  EXPECT_TRUE(needs(std::vector<float>{2, kNan, 3}));
}

TEST(SampleStatisticsBuilder, ListsEveryOccurringInteger) {
  using Values = std::vector<float>;
  const auto distinct = [](const Samples& samples, std::size_t size) {
    return built(samples, size, 2).distinct_values();
  };
  EXPECT_EQ(distinct(std::vector<std::uint8_t>{255, 3, 0, 3}, 4), (Values{0, 3, 255}));
  EXPECT_EQ(distinct(std::vector<std::int8_t>{127, -128, 0, -1}, 4), (Values{-128, -1, 0, 127}));
  EXPECT_EQ(distinct(std::vector<std::uint16_t>{65535, 7, 7}, 3), (Values{7, 65535}));
  EXPECT_EQ(distinct(std::vector<std::int16_t>{-32768, 32767, 5}, 3), (Values{-32768, 5, 32767}));
}

TEST(SampleStatisticsBuilder, KeepsFifteenFractionBitsOfDistinctFloats) {
  using Values = std::vector<float>;
  const auto distinct = [](const std::vector<float>& samples) {
    return built(samples, samples.size(), 3).distinct_values();
  };
  const float largest = std::numeric_limits<float>::max();
  const Values extremes = distinct({largest, 1, kNan, -0.0F, 0, -2, -largest, 1});
  ASSERT_EQ(extremes.size(), 5u);
  EXPECT_EQ(extremes[0], -largest);
  EXPECT_LE(extremes[1], -2);
  EXPECT_GT(extremes[1], -2 - std::ldexp(1.0F, -13));
  EXPECT_EQ(extremes[2], 0);
  EXPECT_EQ(extremes[3], 1);
  EXPECT_LE(extremes[4], largest);
  EXPECT_GT(extremes[4] / largest, 1 - std::ldexp(1.0F, -15));
  const float next = 1 + std::ldexp(1.0F, -15);
  const float between = 1 + std::ldexp(1.0F, -16);
  EXPECT_EQ(distinct({0, 1, between, next}), (Values{0, 1, next}));
  EXPECT_EQ(distinct({between, 3}), (Values{between, 3})) << "None lies below the least sample.";
  EXPECT_TRUE(distinct({kNan}).empty());
}

TEST(SampleStatisticsBuilder, ListsDistinctFloatsAscendingAndCloseToTheSamples) {
  const Volume volume = generate(GeneratorKind::kGyroid, {.size = 24, .noise = 0.5});
  const auto& samples = std::get<std::vector<float>>(volume.samples);
  const std::vector<float> distinct = built(volume.samples, samples.size(), 5000).distinct_values();
  EXPECT_TRUE(std::is_sorted(distinct.begin(), distinct.end()));
  EXPECT_EQ(std::adjacent_find(distinct.begin(), distinct.end()), distinct.end());
  for (const float sample : samples) {
    const auto above = std::upper_bound(distinct.begin(), distinct.end(), sample);
    ASSERT_NE(above, distinct.begin());
    EXPECT_LE(sample - *std::prev(above), std::abs(sample) * std::ldexp(1.0F, -14));
  }
}

TEST(SampleStatisticsBuilder, AcceptsNoSamples) {
  for (const SampleType type : {SampleType::kU8, SampleType::kI16, SampleType::kF32}) {
    const SampleStatistics facts = SampleStatisticsBuilder(type).finish();
    EXPECT_EQ(facts.min, 0);
    EXPECT_EQ(facts.max, 0);
    EXPECT_EQ(facts.histogram, (Histogram{-0.5, 0.5, {0}}));
  }
}

TEST(SuggestedIsovalues, SeparateTheClassesOfAHistogram) {
  Histogram histogram{-0.5, 99.5, std::vector<std::uint64_t>(100)};
  for (const std::size_t center : {10u, 40u, 80u}) {
    for (std::size_t i = center - 3; i <= center + 3; ++i) histogram.counts[i] = 50;
  }
  const std::vector<double> isovalues = suggested_isovalues(histogram);
  ASSERT_GE(isovalues.size(), 2u);
  const auto suggests = [&](double low, double high) {
    for (const double value : isovalues) {
      if (value > low && value < high) return true;
    }
    return false;
  };
  EXPECT_TRUE(suggests(13, 37));
  EXPECT_TRUE(suggests(43, 77));
}

TEST(SuggestedIsovalues, PreferDifferentSurfaces) {
  // Two large classes far apart with a long slope between them, and a small class above.
  Histogram histogram{.low = 0, .high = 200, .counts = std::vector<std::uint64_t>(200, 20)};
  for (std::size_t bin = 0; bin < 10; ++bin) {
    histogram.counts[bin] = 10'000;
    histogram.counts[120 + bin] = 8'000;
    histogram.counts[180 + bin] = 1'500;
  }
  const std::vector<double> isovalues = suggested_isovalues(histogram);
  ASSERT_GE(isovalues.size(), 2U);
  EXPECT_GT(isovalues[0], 9);
  EXPECT_LT(isovalues[0], 121);
  EXPECT_GT(isovalues[1], 129);
  EXPECT_LT(isovalues[1], 181);
}

TEST(SuggestedIsovalues, SeparateTwoValuesInTheMiddle) {
  const Volume box = generate(GeneratorKind::kBox, {.size = 17});
  EXPECT_EQ(statistics(box).suggested_isovalues, std::vector<double>{127.5});
}

TEST(SuggestedIsovalues, LieInsideTheRangeAndBetweenIntegers) {
  const Volume head = generate(GeneratorKind::kHead, {.size = 40, .noise = 20});
  const SampleStatistics facts = statistics(head);
  EXPECT_GE(facts.suggested_isovalues.size(), 2u);
  EXPECT_LE(facts.suggested_isovalues.size(), kMaxSuggestedIsovalues);
  for (const double isovalue : facts.suggested_isovalues) {
    EXPECT_GT(isovalue, facts.min);
    EXPECT_LT(isovalue, facts.max);
    EXPECT_EQ(isovalue - std::floor(isovalue), 0.5) << isovalue;
  }
}

DatasetInfo info_of_values(double min, double max, const std::string& unit,
                           std::vector<double> suggested) {
  DatasetInfo info;
  info.min = min;
  info.max = max;
  info.meaning.value_unit = unit;
  info.histogram = {.low = min, .high = max, .counts = {1}};
  info.suggested_isovalues = std::move(suggested);
  return info;
}

TEST(PreferKnownIsovalues, PrefersSkinAndBoneForCt) {
  DatasetInfo by_unit = info_of_values(-1000, 2000, "HU", {-784, -256, 700});
  prefer_known_isovalues(std::nullopt, by_unit);
  EXPECT_EQ(by_unit.suggested_isovalues, (std::vector<double>{-300.5, 300.5, -784, 700}))
      << "-256 hardly differs from the skin";
  DatasetInfo by_range = info_of_values(-1024, 3071, "", {100});
  prefer_known_isovalues(std::nullopt, by_range);
  EXPECT_EQ(by_range.suggested_isovalues[0], -300.5);
  DatasetInfo soft_tissue = info_of_values(-1000, 250, "HU", {-500});
  prefer_known_isovalues(std::nullopt, soft_tissue);
  EXPECT_EQ(soft_tissue.suggested_isovalues, (std::vector<double>{-300.5, -500}));
}

TEST(PreferKnownIsovalues, KeepsTheSuggestionsOfOtherData) {
  for (const auto& [min, max, unit] : {std::tuple<double, double, std::string>{0, 255, ""},
                                       {-1024, 3071, "K"},
                                       {-1000, 300, ""}}) {
    DatasetInfo info = info_of_values(min, max, unit, {1, 2});
    prefer_known_isovalues(std::nullopt, info);
    EXPECT_EQ(info.suggested_isovalues, (std::vector<double>{1, 2})) << min << " " << unit;
  }
}

TEST(PreferKnownIsovalues, PrefersTheSourcesRecommendation) {
  DatasetInfo info = info_of_values(0, 100, "", {10, 20, 30, 40, 50});
  prefer_known_isovalues(41, info);
  EXPECT_EQ(info.suggested_isovalues, (std::vector<double>{41, 10, 20, 30, 50}));
  prefer_known_isovalues(101, info);
  EXPECT_EQ(info.suggested_isovalues[0], 41);
  prefer_known_isovalues(70, info);
  EXPECT_EQ(info.suggested_isovalues.size(), kMaxSuggestedIsovalues);
}

TEST(DatasetStatisticsText, PrintsTheFactsOfAVolume) {
  Volume volume = generate(GeneratorKind::kBox, {.size = 17});
  volume.spacing = {1, 2, 3};
  volume.index_to_world = {.columns = {Vec3{1, 0, 0}, Vec3{0, 2, 0}, Vec3{0, 0, 3}},
                           .translation = {4, 5, 6}};
  const DatasetInfo info = describe(volume, "box", 0.0, 1);
  EXPECT_EQ(info.name, "box");
  EXPECT_EQ(info.dims, volume.dims);
  EXPECT_EQ(info.type, SampleType::kU8);
  EXPECT_EQ(info.spacing, volume.spacing);
  EXPECT_EQ(info.index_to_world, volume.index_to_world);
  EXPECT_EQ(info.outside, 0.0);
  EXPECT_EQ(info.grid_exponent, 5);  // 16 steps and a margin of 1 on both sides.
  EXPECT_TRUE(check_info(info));
  EXPECT_EQ(describe(volume, "box", std::nullopt, 0).grid_exponent, 4);
}

TEST(DatasetStatisticsText, RejectsOptionsOutsideTheirRange) {
  const Volume volume = row_of(std::vector<std::uint8_t>{1, 2});
  const auto refused = [&](const std::string& name, std::optional<double> outside,
                           std::int32_t margin) -> std::string {
    try {
      (void)describe(volume, name, outside, margin);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(refused("h\xC3\xA4nd \xF0\x9F\xA6\x8E", 1.0, 3), "accepted");
  EXPECT_EQ(refused(std::string(255, 'a'), {}, 0), "accepted");
  for (const std::string& name :
       {std::string(), std::string(256, 'a'), std::string("a/b"), std::string("a\nb"),
        std::string("a\0b", 3), std::string("\x7F"), std::string("\xFF"), std::string("\xC3"),
        std::string("\xC0\xAF"), std::string("\xE0\x80\xAF"), std::string("\xED\xA0\x80"),
        std::string("\xF4\x90\x80\x80"), std::string("."), std::string(".."),
        std::string("a\xE2\x80\xAE"), std::string("a\xC2\x9B")}) {
    EXPECT_NE(refused(name, {}, 0).find("name"), std::string::npos) << name;
  }
  EXPECT_NE(refused("a", {}, -1).find("margin"), std::string::npos);
  EXPECT_NE(refused("a", {}, 20000).find("margin"), std::string::npos);
  EXPECT_NE(refused("a", {}, 16384).find("largest grid"), std::string::npos);
  EXPECT_NE(refused("a", std::nan(""), 0).find("outside"), std::string::npos);
  EXPECT_NE(refused("a", 1e300, 0).find("outside"), std::string::npos);
}

}  // namespace
}  // namespace multitetra
