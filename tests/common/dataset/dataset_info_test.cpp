#include "common/dataset/dataset_info.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "common/request/isosurface_request.hpp"
#include "common/request/shell_step.hpp"

namespace multitetra {
namespace {

DatasetInfo head() {
  return {.name = "head",
          .dims = {128, 128, 112},
          .type = SampleType::kU16,
          .spacing = {2, 1, 3},
          .index_to_world = {.columns = {Vec3{2, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 3}},
                             .translation = {100, 200, 300}},
          .outside = {},
          .grid_exponent = 7,
          .histogram = {},
          .suggested_isovalues = {}};
}

TEST(SampleType, IsFoundByName) {
  for (const SampleType type :
       {SampleType::kU8, SampleType::kI8, SampleType::kU16, SampleType::kI16, SampleType::kF32}) {
    EXPECT_EQ(sample_type_from(name(type)), type);
  }
  EXPECT_EQ(sample_type_from("f64"), std::nullopt);
  EXPECT_EQ(sample_type_from(""), std::nullopt);
  EXPECT_EQ(bytes_per_sample(SampleType::kI8), 1);
  EXPECT_EQ(bytes_per_sample(SampleType::kU16), 2);
  EXPECT_EQ(bytes_per_sample(SampleType::kF32), 4);
}

TEST(GridExponent, IsTheSmallestThatHoldsSamplesAndMargin) {
  EXPECT_EQ(grid_exponent_for({1, 1, 1}, 0), 1);
  EXPECT_EQ(grid_exponent_for({3, 1, 1}, 0), 1);
  EXPECT_EQ(grid_exponent_for({4, 1, 1}, 0), 2);
  EXPECT_EQ(grid_exponent_for({128, 128, 112}, 0), 7);
  EXPECT_EQ(grid_exponent_for({129, 2, 2}, 0), 7) << "129 samples are 128 steps";
  EXPECT_EQ(grid_exponent_for({2, 2, 130}, 0), 8);
  EXPECT_EQ(grid_exponent_for({129, 129, 129}, 1), 8);
  EXPECT_EQ(grid_exponent_for({127, 127, 127}, 1), 7);
}

TEST(DatasetInfo, PlacesTheFirstSampleAtTheMargin) {
  DatasetInfo info = head();
  info.margin = 1;
  EXPECT_EQ(grid_to_index(info)({1, 1, 1}), (Vec3{0, 0, 0}));
  EXPECT_EQ(grid_to_world(info)({1, 1, 1}), (Vec3{100, 200, 300}));
  EXPECT_EQ(grid_to_world(info)({2, 3, 4}), (Vec3{102, 202, 309}));
  EXPECT_EQ(voxel_length(info), 1);
}

TEST(DataBorder, LiesAtTheLastSamplesIfOutsideIsVoid) {
  DatasetInfo info = head();
  info.margin = 2;
  const DataBorder border = data_border(info, 3, 0);
  EXPECT_EQ(border.low, (LatticePoint{16, 16, 16}));
  EXPECT_EQ(border.high, (LatticePoint{16 + 127 * 8, 16 + 127 * 8, 16 + 111 * 8}));
  EXPECT_EQ(border.inset, 0);
  EXPECT_FALSE(border.anywhere);
  info.void_samples = 1;
  EXPECT_TRUE(data_border(info, 3, 0).anywhere);
}

TEST(DataBorder, ExtendsInwardAsFarAsAPreviewsTetrahedraOverlapIt) {
  const auto inset = [](double topology_tolerance, std::int32_t finest_spacing) {
    return data_border(head(), 3, topology_tolerance, finest_spacing).inset / 8;
  };
  EXPECT_EQ(inset(0, 1), 0);
  EXPECT_EQ(inset(0.5, 1), 0) << "no flip has a spacing below 1";
  EXPECT_EQ(inset(1, 1), 1);
  EXPECT_EQ(inset(3.9, 1), 3);
  EXPECT_EQ(inset(4, 1), 7);
  EXPECT_EQ(inset(1, 8), 7);
  EXPECT_GE(inset(1e300, 1), 127) << "no overflow";
}

TEST(DataBorder, LiesAtTheGridsEndIfOutsideIsAValue) {
  DatasetInfo info = head();
  info.outside = 0;
  info.grid_exponent = 7;
  const DataBorder border = data_border(info, 5, 2);
  EXPECT_EQ(border.low, (LatticePoint{0, 0, 0}));
  EXPECT_EQ(border.high, (LatticePoint{4096, 4096, 4096}));
  EXPECT_EQ(border.inset, 0);
}

// ---- the request

TEST(IsosurfaceRequest, AcceptsValuesWithinTheirRanges) {
  EXPECT_TRUE(validated({}));
  EXPECT_TRUE(validated({.isovalue = -1e300, .error = 0}));
  EXPECT_TRUE(validated({.error = 1e9, .topology_tolerance = 4, .lattice_resolution = 8}));
}

TEST(IsosurfaceRequest, NamesTheFieldAndItsRangeInErrors) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const auto expect_invalid = [](const IsosurfaceRequest& request, const std::string& text) {
    const auto result = validated(request);
    ASSERT_FALSE(result) << text;
    EXPECT_EQ(result.error().code, ErrorCode::kInvalidArgument);
    EXPECT_NE(result.error().text.find(text), std::string::npos) << result.error().text;
  };
  expect_invalid({.isovalue = nan}, "isovalue is NaN");
  expect_invalid({.isovalue = -infinity}, "isovalue is -infinity");
  expect_invalid({.error = -0.25}, "threshold is -0.25;");
  expect_invalid({.error = -1e-9}, "threshold is -1e-09;");
  expect_invalid({.error = infinity}, "threshold is infinity");
  expect_invalid({.topology_tolerance = -2}, "tolerance is -2;");
  expect_invalid({.topology_tolerance = nan}, "tolerance is NaN");
  expect_invalid({.lattice_resolution = 0}, "resolution is 0;");
  expect_invalid({.lattice_resolution = 9}, "from 1 to 8");
}

TEST(IsosurfaceRequest, RoundTripsNamesOfChoices) {
  for (const auto measure : {ErrorMeasure::kCertified, ErrorMeasure::kPaper}) {
    EXPECT_EQ(error_measure_from(name(measure)), measure);
  }
  for (const auto rule : {TopologyRule::kExact, TopologyRule::kPaper}) {
    EXPECT_EQ(topology_rule_from(name(rule)), rule);
  }
  for (const auto unit : {ErrorUnit::kVoxel, ErrorUnit::kWorld}) {
    EXPECT_EQ(error_unit_from(name(unit)), unit);
  }
  EXPECT_EQ(error_measure_from("Paper"), std::nullopt);
  EXPECT_EQ(topology_rule_from(""), std::nullopt);
  EXPECT_EQ(error_unit_from("mm"), std::nullopt);
}

// Axes from files are at right angles only up to the rounding of their numbers.
TEST(ShellStep, HasAnErrorBoundOfTheLongestDiagonal) {
  DatasetInfo info;
  info.index_to_world.columns = {Vec3{1, 1e-4, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  const double bound = error_bound(quantized_shells(1), info, 2);
  EXPECT_DOUBLE_EQ(bound, 2 * longest_cell_diagonal(info) / 6);
  EXPECT_GT(bound, 2 * std::sqrt(3.0) / 6 * (1 + 1e-5));
  EXPECT_EQ(error_bound(ShellStep{}, info, 2), 0);
}

TEST(LatticeRounding, FollowsTheLongestDiagonal) {
  DatasetInfo info;
  EXPECT_DOUBLE_EQ(lattice_rounding_world(info, 5), std::sqrt(3.0) / 32);
  info.index_to_world.columns = {Vec3{1, 0, 0}, Vec3{0, 2, 0}, Vec3{0, 0, 2}};
  EXPECT_DOUBLE_EQ(lattice_rounding_world(info, 1), 1.5);
  info.index_to_world.columns = {Vec3{1, 0, 0}, Vec3{1, 1, 0}, Vec3{0, 0, 1}};
  EXPECT_DOUBLE_EQ(lattice_rounding_world(info, 1), std::sqrt(6.0) / 2) << "sheared";
}

}  // namespace
}  // namespace multitetra
