#include "common/cli/human_units.hpp"

#include <gtest/gtest.h>

namespace multitetra {
namespace {

TEST(HumanSuggestions, NameTissuesOnlyForComputedTomography) {
  DatasetInfo info;
  EXPECT_EQ(human_suggestions(info), "none");
  info.suggested_isovalues = {-900, -300.5, 300.5, 40, 2500};
  EXPECT_EQ(human_suggestions(info), "-900, -300.5, 300.5, 40, 2500");
  info.meaning.value_unit = "HU";
  EXPECT_EQ(human_suggestions(info),
            "-900, -300.5 (skin), 300.5 (bone), 40 (soft tissue), 2500 (enamel, metal)");
}

DatasetInfo between(double low, double high) {
  DatasetInfo info;
  info.min = low;
  info.max = high;
  return info;
}

TEST(HumanValue, HasTheDigitsOfTheDataWhateverItsOffset) {
  const DatasetInfo info = between(1737399.8, 1737400.2);
  EXPECT_EQ(human_value(info.min, info), "1737399.8");
  EXPECT_EQ(human_value(1737400.00125, info), "1737400.00125");
  EXPECT_EQ(human_value(0.1 + 0.2, between(0, 1)), "0.3");
  EXPECT_EQ(human_value(-3e-7, between(0, 1)), "0");
  EXPECT_EQ(human_value(2e-12, between(0, 1e-11)), "0.000000000002");
  EXPECT_EQ(human_value(7, between(7, 7)), "7");
  EXPECT_EQ(human_value(1e300, between(0, 1e300)), "1e+300");
}

TEST(HumanPlace, HasTheDigitsOfAVoxel) {
  EXPECT_EQ(human_place({500012.251, 5400031.5, -0.0001}, 0.5), "500012.251 5400031.5 0");
}

// Such times differ.
TEST(HumanMember, HasTheWholeTime) {
  EXPECT_EQ(human_member({.series = "e", .time = 1700000060, .time_unit = "s"}),
            "\"e\", time 1700000060 s");
  EXPECT_EQ(human_member({.series = "e", .time = 1700000000, .time_unit = "s"}),
            "\"e\", time 1700000000 s");
  EXPECT_EQ(human_member({.series = "e", .time = 0, .time_unit = "s"}), "\"e\", time 0 s");
  EXPECT_EQ(human_member({.series = "e", .time = 2026.0001, .time_unit = "a"}),
            "\"e\", time 2026.0001 a");
}

}  // namespace
}  // namespace multitetra
