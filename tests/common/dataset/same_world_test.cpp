#include "common/dataset/same_world.hpp"

#include <gtest/gtest.h>

#include "common/request/scalar_request.hpp"
#include "tests/support/texts.hpp"

namespace multitetra {
namespace {

using testing::expect_contains;

// Ten samples per side, a millimetre apart, starting at `origin`.
DatasetInfo cube_at(const Vec3& origin) {
  DatasetInfo info;
  info.name = "cube";
  info.dims = {10, 10, 10};
  info.index_to_world.translation = origin;
  info.meaning = {.space = WorldSpace::kLps, .length_unit = "mm", .value_unit = "HU"};
  return info;
}

TEST(SameWorld, AcceptsOverlappingBoxesWithAnyGrids) {
  DatasetInfo values = cube_at({9, 0, 0});
  values.dims = {3, 40, 5};
  values.meaning.value_unit = "K";
  EXPECT_EQ(world_mismatch(cube_at({0, 0, 0}), values), "");
}

TEST(SameWorld, DistinguishesAxesUnitsAndPositions) {
  const DatasetInfo surface = cube_at({0, 0, 0});
  DatasetInfo values = surface;
  values.meaning.space = WorldSpace::kRas;
  expect_contains(world_mismatch(surface, values), "RAS");
  values = surface;
  values.meaning.length_unit = "µm";
  expect_contains(world_mismatch(surface, values), "µm");
  expect_contains(world_mismatch(surface, cube_at({0, 10, 0})), "along y from 10 to 19");
}

TEST(SameWorld, IgnoresUnknownProperties) {
  const DatasetInfo surface = cube_at({0, 0, 0});
  DatasetInfo values = surface;
  values.meaning = {};
  EXPECT_EQ(world_mismatch(surface, values), "");
}

TEST(SameWorld, IsRequiredOfColorsUnlessAllowed) {
  const DatasetInfo surface = cube_at({0, 0, 0});
  DatasetInfo values = surface;
  ScalarRequest request{.dataset = "cube"};
  EXPECT_TRUE(check_same_world(request, surface, values));
  values.meaning.length_unit = "cm";
  const auto refused = check_same_world(request, surface, values);
  ASSERT_FALSE(refused);
  expect_contains(refused.error().text, "units of length");
  expect_contains(refused.error().text, "color_anyway");
  request.in_any_world = true;
  EXPECT_TRUE(check_same_world(request, surface, values));
}

}  // namespace
}  // namespace multitetra
