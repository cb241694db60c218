// Exact errors reproduce the counts of an independent implementation on public volumes.

#include <gtest/gtest.h>

#include <cmath>
#include <ostream>

#include "tests/support/isosurfaces.hpp"
#include "tests/support/public_volumes.hpp"

namespace multitetra::testing {
namespace {

struct Counts {
  std::int64_t tetrahedra;
  std::int64_t active_tetrahedra;
  std::int64_t triangles;
  std::int64_t vertices;
  std::int64_t border_edges;
};

struct Row {
  Case requested;
  Counts expected;
};

struct Table {
  std::optional<double> outside = std::nullopt;
  std::int32_t margin = 0;
  std::int64_t euler_characteristic = 0;
  std::int64_t components = 0;
  std::vector<Row> rows = {};
};

// Expects `count` within 0.01 % of `expected`.
void expect_count(std::int64_t count, std::int64_t expected, const char* what) {
  EXPECT_LE(std::abs(static_cast<double>(count - expected)), 1e-4 * static_cast<double>(expected))
      << what << ": " << count << ", expected " << expected;
}

void expect_table(const std::optional<Volume>& volume, const Table& table) {
  if (!volume) {
    GTEST_SKIP() << "NOT TESTED: the public volumes are not at " << MULTITETRA_PUBLIC_DATA
                 << "; they are not part of the project.";
  }
  ReferenceIsosurfaces isosurface(*volume, table.outside, table.margin);
  for (const auto& [requested, expected] : table.rows) {
    SCOPED_TRACE(::testing::Message()
                 << "isovalue " << requested.isovalue << ", threshold " << requested.threshold
                 << ", bound " << name(requested.error_measure) << ", rule " << name(requested.rule)
                 << ", tolerance " << requested.topology_tolerance);
    const Surface surface = isosurface(requested);
    expect_count(static_cast<std::int64_t>(surface.tetrahedra), expected.tetrahedra, "tetrahedra");
    expect_count(static_cast<std::int64_t>(surface.active_tetrahedra), expected.active_tetrahedra,
                 "crossed");
    expect_count(surface.topology.triangles, expected.triangles, "triangles");
    expect_count(surface.topology.vertices, expected.vertices, "vertices");
    EXPECT_TRUE(surface.topology.is_sound());
    if (requested.topology_tolerance == 0) {
      expect_count(surface.topology.border_edges, expected.border_edges, "border edges");
      EXPECT_EQ(surface.topology.euler_characteristic, table.euler_characteristic);
      EXPECT_EQ(surface.topology.components, table.components);
    }
  }
}

Case paper(double isovalue, double threshold) {
  return {.isovalue = isovalue, .threshold = threshold};
}
Case rule_exact(double isovalue, double threshold) {
  return {.isovalue = isovalue, .threshold = threshold, .rule = TopologyRule::kExact};
}
Case certified(double isovalue, double threshold, TopologyRule rule = TopologyRule::kPaper) {
  return {.isovalue = isovalue,
          .threshold = threshold,
          .error_measure = ErrorMeasure::kCertified,
          .rule = rule};
}
// A finer threshold in one half of the samples, as in the paper's Fig. 11.
Case finer_for_low_x(double isovalue, double threshold, double finer, double last_x) {
  return {
      .isovalue = isovalue,
      .threshold = threshold,
      .thresholds = {.coordinates = CoordinateSystem::kIndex,
                     .regions = {{.shape = BoxShape{.low = {0, 0, 0}, .high = {last_x, 1000, 1000}},
                                  .threshold = finer}}}};
}
Case tolerant(double isovalue, double threshold, double tolerance) {
  return {.isovalue = isovalue, .threshold = threshold, .topology_tolerance = tolerance};
}

TEST(ReferenceCounts, MatchCtHeadSkinWithZeroOutside) {
  expect_table(ct_head(), {.outside = 0,
                           .euler_characteristic = -502,
                           .components = 223,
                           .rows = {{paper(500.5, 0), {1582486, 557888, 735808, 367734, 664}},
                                    {paper(500.5, 0.5), {709830, 320204, 419209, 209343, 481}},
                                    {paper(500.5, 1.5), {357262, 182758, 240207, 119807, 411}},
                                    {paper(500.5, 2.5), {325456, 170588, 224149, 111777, 409}},
                                    {paper(500.5, 4), {319410, 168125, 220927, 110166, 409}},
                                    {paper(500.5, 1e9), {318526, 167714, 220389, 109897, 409}},
                                    {rule_exact(500.5, 1.5), {287712, 145033, 192528, 95964, 404}},
                                    {rule_exact(500.5, 4), {226766, 120277, 159999, 79697, 399}}}});
}

TEST(ReferenceCounts, MatchCtHeadBoneWithZeroOutside) {
  expect_table(ct_head(), {.outside = 0,
                           .euler_characteristic = -584,
                           .components = 227,
                           .rows = {{paper(1200.5, 0), {1356550, 489536, 642648, 320740, 0}},
                                    {paper(1200.5, 1.5), {282200, 145309, 190364, 94598, 0}},
                                    {paper(1200.5, 4), {231396, 125198, 164056, 81444, 0}}}});
}

TEST(ReferenceCounts, MatchCtHeadSkinWithVoidOutside) {
  expect_table(
      ct_head(),
      {.outside = std::nullopt,
       .euler_characteristic = -534,
       .components = 223,
       .rows = {{paper(500.5, 0), {1575340, 548132, 723145, 361984, 1891}},
                {paper(500.5, 1.5), {379884, 181376, 238246, 119409, 1640}},
                {paper(500.5, 4), {343384, 167327, 219774, 110172, 1638}},
                {finer_for_low_x(500.5, 4, 0, 63), {1092616, 401430, 529084, 264889, 1762}},
                {certified(500.5, 1), {670216, 293250, 383507, 192067, 1695}},
                {certified(500.5, 4), {412910, 194019, 255111, 127843, 1643}},
                {certified(500.5, 4, TopologyRule::kExact), {362908, 164895, 219040, 109803, 1634}},
                {tolerant(500.5, 1.5, 1), {180566, 75988, 99845, 50318, 0}},
                {tolerant(500.5, 4, 2), {23816, 9505, 12272, 6233, 0}}}});
}

TEST(ReferenceCounts, MatchCtHeadSkinClosedOnAllSides) {
  expect_table(ct_head(), {.outside = 0,
                           .margin = 1,
                           .euler_characteristic = -472,
                           .components = 223,
                           .rows = {{paper(500.5, 0), {1597068, 564744, 745220, 372138, 0}},
                                    {paper(500.5, 4), {311812, 156713, 206314, 102685, 0}}}});
}

TEST(ReferenceCounts, MatchFuel) {
  expect_table(fuel(), {.euler_characteristic = -5,
                        .components = 1,
                        .rows = {{paper(60.5, 0), {39322, 11032, 14438, 7232, 36}},
                                 {paper(60.5, 0.5), {15534, 4870, 6354, 3187, 30}},
                                 {paper(60.5, 1.5), {7936, 2220, 2878, 1440, 12}},
                                 {paper(60.5, 4), {7180, 1933, 2494, 1246, 8}}}});
}

TEST(ReferenceCounts, MatchNeghip) {
  expect_table(neghip(), {.euler_characteristic = 22,
                          .components = 18,
                          .rows = {{paper(80.5, 0), {175454, 52589, 68806, 34525, 200}},
                                   {paper(80.5, 1.5), {31240, 10932, 14170, 7177, 140}},
                                   {paper(80.5, 4), {27496, 9497, 12311, 6246, 137}},
                                   {rule_exact(80.5, 1.5), {21194, 7793, 10119, 5150, 137}},
                                   {rule_exact(80.5, 4), {10826, 3903, 5023, 2600, 133}}}});
}

TEST(ReferenceCounts, MatchTooth) {
  expect_table(tooth(), {.euler_characteristic = -2,
                         .components = 1,
                         .rows = {{paper(195.5, 0), {508908, 149507, 195698, 97847, 0}},
                                  {paper(195.5, 1.5), {69264, 25510, 33176, 16586, 0}},
                                  {paper(195.5, 4), {51762, 18317, 23706, 11851, 0}}}});
}

TEST(ReferenceCounts, MatchHeadsqWithWorldSpacing) {
  expect_table(headsq(), {.euler_characteristic = -194,
                          .components = 52,
                          .rows = {{paper(1150.5, 0), {478026, 179414, 236264, 118343, 810}},
                                   {paper(1150.5, 2.25), {203844, 97842, 128058, 64122, 574}},
                                   {paper(1150.5, 6), {103152, 54557, 71510, 35764, 406}}}});
}

}  // namespace
}  // namespace multitetra::testing
