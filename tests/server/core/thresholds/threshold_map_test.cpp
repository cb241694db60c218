// Compares threshold maps with their definition and checks the monotonicity that models depend on,
// over random maps: rotated, sheared and mirrored data, anisotropic spacing, all kinds of parts.
#include "server/core/thresholds/threshold_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>

#include "server/core/errors/error_based_model.hpp"
#include "tests/support/threshold_maps.hpp"

namespace multitetra::testing {
namespace {

DatasetInfo random_info(std::mt19937_64& random) {
  DatasetInfo info;
  for (std::int32_t& samples : info.dims) {
    samples = 1 + static_cast<std::int32_t>(random() % 60);
  }
  info.margin = static_cast<std::int32_t>(random() % 3);
  if (random() % 2 == 0) info.outside = 0;
  info.grid_exponent = grid_exponent_for(info.dims, info.margin);
  if (random() % 2 == 0) {
    info.spacing = {0.7, 1.25, 3};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      info.index_to_world.columns[axis][axis] = info.spacing[axis];
    }
    info.index_to_world.translation = {-10, 25, 3.5};
  } else {
    info.index_to_world = random_affine(1.5, random);
    info.spacing = {1.5, 1.5, 1.5};
  }
  return info;
}

IsosurfaceRequest random_request(const DatasetInfo& info, std::mt19937_64& random) {
  IsosurfaceRequest request{.error = between(0.5, 5, random),
                            .unit = random() % 2 == 0 ? ErrorUnit::kVoxel : ErrorUnit::kWorld,
                            .thresholds = random_thresholds(info, random)};
  EXPECT_TRUE(validated(request)) << validated(request).error().text;
  return request;
}

// A random place within the extent of the samples, where thresholds are evaluated.
Vec3 random_grid_place(const DatasetInfo& info, std::mt19937_64& random) {
  Vec3 place;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    place[axis] = info.margin + (info.dims[axis] - 1) * fields::uniform(random);
  }
  return place;
}

Vec3 place_in(const Box& box, std::mt19937_64& random) {
  Vec3 place;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    place[axis] = std::min(
        box.low[axis] + (box.high[axis] - box.low[axis]) * fields::uniform(random), box.high[axis]);
  }
  return place;
}

Box random_box(const Box& outer, std::mt19937_64& random) {
  Box box{place_in(outer, random), place_in(outer, random)};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (box.low[axis] > box.high[axis]) std::swap(box.low[axis], box.high[axis]);
    if (random() % 8 == 0) box.low[axis] = outer.low[axis];
    if (random() % 8 == 0) box.high[axis] = outer.high[axis];
    // Snapped to where octree cubes meet.
    const double snapped =
        std::clamp(4 * std::round(box.low[axis] / 4), outer.low[axis], outer.high[axis]);
    if (random() % 4 == 0) box.low[axis] = std::min(snapped, box.high[axis]);
    if (random() % 4 == 0) box.high[axis] = std::max(snapped, box.low[axis]);
    if (random() % 8 == 0) box.high[axis] = box.low[axis];
  }
  return box;
}

Box whole_grid(const DatasetInfo& info) {
  const double side = 1 << info.grid_exponent;
  return {{0, 0, 0}, {side, side, side}};
}

// Calls `visit(info, request, map, random)` for `count` random maps.
template <typename Visit>
void for_random_maps(int count, const Visit& visit) {
  std::mt19937_64 random(7);
  for (int i = 0; i < count && !::testing::Test::HasFailure(); ++i) {
    SCOPED_TRACE(i);
    const DatasetInfo info = random_info(random);
    const IsosurfaceRequest request = random_request(info, random);
    visit(info, request, ThresholdMap(request, info), random);
  }
}

TEST(ThresholdMap, MatchesItsDefinitionInThresholdAt) {
  for_random_maps(300, [](const auto& info, const auto& request, const auto& map, auto& random) {
    for (int i = 0; i < 30; ++i) {
      const Vec3 place = random_grid_place(info, random);
      const double expected = threshold_at(request, info, place);
      EXPECT_NEAR(map.least_in({place, place}), expected, 1e-6 * (1 + expected));
    }
  });
}

TEST(ThresholdMap, BoundsThresholdsFromBelowInLeastIn) {
  for_random_maps(300, [](const auto& info, const auto& request, const auto& map, auto& random) {
    for (int i = 0; i < 10; ++i) {
      const Vec3 middle = random_grid_place(info, random);
      Box box{middle, middle};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        box.low[axis] = std::max<double>(middle[axis] - between(0, 9, random), info.margin);
        box.high[axis] = std::min<double>(middle[axis] + between(0, 9, random),
                                          info.margin + info.dims[axis] - 1);
      }
      const double least = map.least_in(box);
      for (int k = 0; k < 40; ++k) {
        const Vec3 place = place_in(box, random);
        EXPECT_LE(least, map.least_in({place, place}));
        const double expected = threshold_at(request, info, place);
        EXPECT_LE(least, expected + 1e-6 * (1 + expected));
      }
    }
  });
}

TEST(ThresholdMap, NeverDecreasesLeastInForInnerBoxes) {
  for_random_maps(400, [](const auto& info, const auto&, const auto& map, auto& random) {
    for (int i = 0; i < 40; ++i) {
      Box outer = random_box(whole_grid(info), random);
      double least = map.least_in(outer);
      for (int depth = 0; depth < 6; ++depth) {
        const Box inner = random_box(outer, random);
        const double least_inside = map.least_in(inner);
        ASSERT_GE(least_inside, least);
        outer = inner;
        least = least_inside;
      }
    }
  });
}

TEST(ThresholdMap, NeverExceedsChildrenInParentRegions) {
  for_random_maps(60, [](const auto& info, const auto&, const auto& map, auto& random) {
    const Grid grid(info.grid_exponent);
    for (int i = 0; i < 200; ++i) {
      const auto coordinate = [&] {
        return static_cast<std::int32_t>(random() % static_cast<std::uint64_t>(grid.side() + 1));
      };
      const GridPoint at{coordinate(), coordinate(), coordinate()};
      if (at.x % grid.side() == 0 && at.y % grid.side() == 0 && at.z % grid.side() == 0) continue;
      const DividingPoint point(at);
      for (const GridPoint parent : point.parents(grid)) {
        ASSERT_LE(map.least_in(region(DividingPoint(parent))), map.least_in(region(point)));
      }
    }
  });
}

TEST(ThresholdMap, BoundsAllItsThresholds) {
  for_random_maps(200, [](const auto& info, const auto& request, const auto& map, auto& random) {
    EXPECT_EQ(map.largest(), largest_threshold(request, info));
    for (int i = 0; i < 40; ++i) {
      const double least = map.least_in(random_box(whole_grid(info), random));
      EXPECT_GE(least, map.least());
      EXPECT_LE(least, map.largest());
      const double expected = threshold_at(request, info, random_grid_place(info, random));
      EXPECT_LE(expected, map.largest() * (1 + 1e-9));
    }
  });
}

TEST(ThresholdMap, IsTighterInEveryBoxIfTighterEverywhere) {
  for_random_maps(
      100, [](const auto& info, IsosurfaceRequest request, const auto& map, auto& random) {
        request.error *= 0.5;
        request.thresholds.error_floor *= 0.5;
        for (ThresholdRegion& region : request.thresholds.regions) region.threshold *= 0.5;
        if (request.thresholds.grid) {
          auto grid = std::make_shared<ThresholdGrid>(*request.thresholds.grid);
          for (float& threshold : grid->thresholds) threshold *= 0.5F;
          request.thresholds.grid = std::move(grid);
        }
        if (request.thresholds.view) {
          request.thresholds.view->tolerance_pixels *= 0.5;
          if (request.thresholds.view->frustum) request.thresholds.view->frustum->outside *= 0.5;
        }
        const ThresholdMap tighter(request, info);
        for (int i = 0; i < 40; ++i) {
          const Box box = random_box(whole_grid(info), random);
          EXPECT_EQ(tighter.least_in(box), 0.5 * map.least_in(box));  // Halving is exact.
        }
      });
}

// ---- simple maps with exact results

constexpr double kInfinity = std::numeric_limits<double>::infinity();

DatasetInfo cube_of(std::int32_t samples) {
  DatasetInfo info;
  info.dims = {samples, samples, samples};
  info.grid_exponent = grid_exponent_for(info.dims, 0);
  return info;
}

ThresholdMap map_of(LocalThresholds thresholds, double error = 4,
                    const DatasetInfo& info = cube_of(65)) {
  return {{.error = error, .thresholds = std::move(thresholds)}, info};
}

Box box(double x0, double x1) { return {{x0, 10, 10}, {x1, 12, 12}}; }
ThresholdRegion slab(double x0, double x1, double threshold) {
  return {.shape = BoxShape{.low = {x0, -1, -1}, .high = {x1, 99, 99}}, .threshold = threshold};
}

TEST(ThresholdMap, IsUniformWithoutParts) {
  EXPECT_EQ(map_of({}).least_in(box(1, 2)), 4);
  EXPECT_EQ(map_of({.error_floor = 6}).least_in(box(1, 2)), 6);
  EXPECT_EQ(map_of({.error_floor = 3}).least(), 4);
  EXPECT_EQ(ThresholdMap({.error = 1e308, .thresholds = {}},
                         [] {
                           DatasetInfo info = cube_of(9);
                           info.spacing = {100, 100, 100};
                           return info;
                         }())
                .largest(),
            std::numeric_limits<double>::max());
}

TEST(ThresholdMap, UsesTheLastRegionThatContainsThePoint) {
  const ThresholdMap map =
      map_of({.regions = {slab(0, 30, 1), slab(10, 20, 3), slab(15, 16, 0.5)}});
  EXPECT_EQ(map.least_in(box(2, 5)), 1);
  EXPECT_EQ(map.least_in(box(5, 9.9)), 1);
  EXPECT_EQ(map.least_in(box(10, 14)), 3) << "the slab behind is hidden";
  EXPECT_EQ(map.least_in(box(9, 14)), 1);
  EXPECT_EQ(map.least_in(box(12, 15)), 0.5) << "borders belong to regions";
  EXPECT_EQ(map.least_in(box(31, 40)), 4);
  EXPECT_EQ(map.least_in(box(30, 40)), 1);
  EXPECT_EQ(map.least(), 0.5);
  EXPECT_EQ(map.largest(), 4);
}

TEST(ThresholdMap, UsesTheLeastOfAllPartsForMinimum) {
  const ThresholdMap map = map_of({.combination = Combination::kMinimum,
                                   .regions = {slab(0, 30, 1), slab(10, 20, 3), slab(40, 50, 7)}});
  EXPECT_EQ(map.least_in(box(12, 14)), 1);
  EXPECT_EQ(map.least_in(box(42, 44)), 7) << "the error holds only where nothing is said";
  EXPECT_EQ(map.least_in(box(32, 34)), 4);
}

TEST(ThresholdMap, IgnoresHiddenParts) {
  const ThresholdMap map = map_of({.regions = {slab(3, 4, 0), slab(-1, 99, 2.5)}});
  EXPECT_EQ(map.least(), 2.5);
  EXPECT_EQ(map.largest(), 2.5);
}

TEST(ThresholdMap, RaisesThresholdsToAtLeast) {
  const ThresholdMap map = map_of({.regions = {slab(0, 30, 1)}, .error_floor = 2});
  EXPECT_EQ(map.least_in(box(2, 5)), 2);
  EXPECT_EQ(map.least_in(box(40, 41)), 4);
}

TEST(ThresholdMap, MovesIndexRegionsWithTheMargin) {
  DatasetInfo info = cube_of(40);
  info.margin = 5;
  info.grid_exponent = grid_exponent_for(info.dims, 5);
  const ThresholdMap map =
      map_of({.coordinates = CoordinateSystem::kIndex, .regions = {slab(0, 7, 1)}}, 4, info);
  EXPECT_EQ(map.least_in(box(5, 12)), 1);
  EXPECT_EQ(map.least_in(box(12.5, 14)), 4);
}

LocalThresholds grid_of(std::array<std::int32_t, 3> dims, std::vector<float> values, double step) {
  Affine map;
  for (std::size_t axis = 0; axis < 3; ++axis) map.columns[axis][axis] = step;
  return {.grid = std::make_shared<const ThresholdGrid>(
              ThresholdGrid{.dims = dims, .index_to_world = map, .thresholds = std::move(values)})};
}

TEST(ThresholdMap, UsesTheLeastTouchedVoxelOfAGrid) {
  // Voxels of 16 grid steps, from -8 on: 1, 2, none and 3 along x; the grid is wide along y and z.
  const LocalThresholds thresholds = grid_of(
      {4, 5, 5},
      [] {
        std::vector<float> values;
        for (int i = 0; i < 25; ++i) {
          for (const float v : {1.0F, 2.0F, std::nanf(""), 3.0F}) values.push_back(v);
        }
        return values;
      }(),
      16);
  const ThresholdMap map = map_of(thresholds);
  EXPECT_EQ(map.least_in(box(0, 7.9)), 1);
  EXPECT_EQ(map.least_in(box(9, 20)), 2);
  EXPECT_EQ(map.least_in(box(8, 20)), 1) << "borders belong to both";
  EXPECT_EQ(map.least_in(box(25, 39)), 4) << "NaN says nothing";
  EXPECT_EQ(map.least_in(box(41, 55)), 3);
  EXPECT_EQ(map.least_in(box(57, 60)), 4) << "beyond the grid";
  EXPECT_EQ(map.largest(), 4);
  LocalThresholds with_region = thresholds;
  with_region.regions = {slab(0, 64, 3.5)};
  EXPECT_EQ(map_of(with_region).least_in(box(0, 7)), 3.5) << "a region hides the grid";
  with_region.combination = Combination::kMinimum;
  EXPECT_EQ(map_of(with_region).least_in(box(0, 7)), 1);
  EXPECT_EQ(map_of(with_region).least_in(box(25, 39)), 3.5);
}

TEST(ThresholdMap, UsesThePixelSizeAtTheDistanceOfAView) {
  // At 90 degrees the height of the picture is twice its distance.
  const ThresholdView view{
      .eye = {0, 11, 11}, .field_of_view = 90, .height_pixels = 100, .tolerance_pixels = 5};
  const ThresholdMap map = map_of({.view = view});
  EXPECT_DOUBLE_EQ(map.least_in(box(10, 12)), 1);
  EXPECT_DOUBLE_EQ(map.least_in(box(20, 30)), 2);
  EXPECT_EQ(map.least_in(box(0, 3)), 0) << "the eye is in the box";
  ThresholdView narrow = view;
  narrow.field_of_view = 60;
  EXPECT_DOUBLE_EQ(map_of({.view = narrow}).least_in(box(10, 12)),
                   std::tan(3.14159265358979323846 / 6));
}

TEST(ThresholdMap, UsesOutsideBeyondAFrustum) {
  const ThresholdView view{.eye = {32, 11, 11},
                           .field_of_view = 90,
                           .height_pixels = 100,
                           .tolerance_pixels = 5,
                           .frustum = Frustum{.look_at = {64, 11, 11}, .outside = 3}};
  const ThresholdMap map = map_of({.view = view});
  EXPECT_DOUBLE_EQ(map.least_in(box(42, 50)), 1) << "in the picture";
  EXPECT_EQ(map.least_in(box(20, 22)), 3) << "behind the eye";
  EXPECT_DOUBLE_EQ(map.least_in({{42, 32, 10}, {43, 33, 12}}), 3) << "beside the picture";
  EXPECT_EQ(map.least_in(box(20, 40)), 0) << "on both sides of the eye";
}

TEST(ThresholdMap, IsAtLeastTheMinimumForExtremeNumbers) {
  DatasetInfo info = cube_of(9);
  info.index_to_world.translation = {1e300, -1e300, 0};
  EXPECT_EQ(map_of({.regions = {slab(0, 1, 2)}}, 4, info).largest(), 0);
  EXPECT_EQ(map_of({.regions = {slab(0, 1, 2)}, .error_floor = 1}, 4, info).least(), 1);
  for (const double step : {1e-100, 1e-60, 1e60}) {
    const ThresholdMap map = map_of(grid_of({1, 1, 1}, {2}, step));
    EXPECT_TRUE(std::isfinite(map.least_in(box(0, 20)))) << step;
  }
  const ThresholdView view{.eye = {1e100, 0, 0},
                           .field_of_view = std::nextafter(180.0, 0.0),
                           .height_pixels = 1e-100,
                           .tolerance_pixels = 1e300,
                           .frustum = Frustum{.look_at = {0, 0, 0}, .aspect = 1e100}};
  EXPECT_TRUE(std::isfinite(map_of({.view = view}).least_in(box(0, 20))));
}

TEST(ThresholdMap, IsZeroForAViewWithZeroTolerance) {
  for (const double height : {5e-324, 1e-310, 1e-300, 1.0, 1e100}) {
    const ThresholdView view{
        .eye = {0, 11, 11}, .field_of_view = std::nextafter(180.0, 0.0), .height_pixels = height};
    ASSERT_TRUE(check_thresholds({.view = view}));
    for (const Combination combination : {Combination::kInOrder, Combination::kMinimum}) {
      const ThresholdMap map = map_of({.combination = combination, .view = view});
      EXPECT_EQ(map.least_in(box(10, 12)), 0) << height;
      EXPECT_EQ(map.largest(), 0) << height;
    }
  }
}

// ---- ten thousand regions

TEST(ThresholdMap, IsMonotoneWithTenThousandRegions) {
  std::mt19937_64 random(11);
  const DatasetInfo info = cube_of(257);
  for (const bool same_place : {false, true}) {
    IsosurfaceRequest request{.error = 4};
    for (std::size_t i = 0; i < kMaxThresholdRegions; ++i) {
      request.thresholds.regions.push_back(
          random_region(info, CoordinateSystem::kWorld, 10, random));
      // Borders that cross in the same cubes at every level of the octree.
      if (same_place) {
        request.thresholds.regions.back().shape = BallShape{
            .center = {100, 100, 100}, .radius = 40 + 1e-3 * static_cast<double>(i % 100)};
      }
    }
    const ThresholdMap map(request, info);
    for (int i = 0; i < 200; ++i) {
      // Around the common border of the balls, or anywhere.
      const double angle = between(0, 6, random);
      const Vec3 corner = same_place
                              ? Vec3{100 + 40 * std::cos(angle), 95, 100 + 40 * std::sin(angle)}
                              : random_grid_place(info, random);
      const Box outer = clamped({corner, {corner[0] + 12, corner[1] + 12, corner[2] + 12}},
                                {{0, 0, 0}, {256, 256, 256}});
      const Box inner = random_box(outer, random);
      const Vec3 place = place_in(inner, random);
      EXPECT_LE(map.least_in(outer), map.least_in(inner));
      EXPECT_LE(map.least_in(inner), map.least_in({place, place}));
      EXPECT_LE(map.least_in(inner), threshold_at(request, info, place));
    }
  }
}

TEST(ThresholdMap, IsCancellableWithManyRegions) {
  std::mt19937_64 random(12);
  const DatasetInfo info = cube_of(257);
  IsosurfaceRequest request{.error = 4};
  for (std::size_t i = 0; i < kMaxThresholdRegions; ++i) {
    request.thresholds.regions.push_back(random_region(info, CoordinateSystem::kWorld, 10, random));
  }
  struct Enough {};
  int checks = 0;
  const auto give_up = [&] {
    if (++checks == 10) throw Enough{};
  };
  EXPECT_THROW(ThresholdMap(request, info, give_up), Enough);
  EXPECT_EQ(checks, 10);
}

}  // namespace
}  // namespace multitetra::testing
