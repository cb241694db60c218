#include "common/request/request_key.hpp"

#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace multitetra {
namespace {

std::shared_ptr<const ThresholdGrid> grid(std::vector<float> thresholds,
                                          std::array<std::int32_t, 3> dims = {2, 1, 1}) {
  return std::make_shared<ThresholdGrid>(
      ThresholdGrid{.dims = dims, .index_to_world = {}, .thresholds = std::move(thresholds)});
}

IsosurfaceRequest full() {
  IsosurfaceRequest request{.isovalue = 60.5};
  request.thresholds.regions = {{.shape = BoxShape{{0, 0, 0}, {1, 1, 1}}, .threshold = 0.5}};
  request.thresholds.grid = grid({1, 2});
  request.thresholds.view = ThresholdView{.eye = {1, 2, 3},
                                          .field_of_view = 30,
                                          .height_pixels = 600,
                                          .tolerance_pixels = 1,
                                          .frustum = Frustum{.look_at = {4, 5, 6}}};
  return request;
}

using Change = std::function<void(IsosurfaceRequest&)>;

TEST(RequestKey, DiffersForDifferentRequests) {
  const std::vector<Change> changes = {
      [](auto&) {},
      [](auto& r) { r.isovalue = std::nextafter(r.isovalue, 100); },
      [](auto& r) { r.error = 2; },
      [](auto& r) { r.unit = ErrorUnit::kWorld; },
      [](auto& r) { r.error_measure = ErrorMeasure::kPaper; },
      [](auto& r) { r.topology_rule = TopologyRule::kPaper; },
      [](auto& r) { r.topology_tolerance = 4; },
      [](auto& r) { ++r.lattice_resolution; },
      [](auto& r) { r.max_triangles = 5; },
      [](auto& r) { r.max_bytes = 5; },
      [](auto& r) { r.simplify = true; },
      [](auto& r) { r.intersection_free = true; },
      [](auto& r) { r.normal_bits = 8; },
      [](auto& r) { r.cell = OctreeNode{}; },
      [](auto& r) {
        r.cell = OctreeNode{.cube = {4, 0, 0, 0}};
      },
      [](auto& r) {
        r.cell = OctreeNode{.cube = {4, 0, 0, 1}};
      },
      [](auto& r) {
        r.cell = OctreeNode{.cube = {4, 0, 0, 0}, .finest_spacing = 2};
      },
      [](auto& r) { r.thresholds.coordinates = CoordinateSystem::kIndex; },
      [](auto& r) { r.thresholds.combination = Combination::kMinimum; },
      [](auto& r) { r.thresholds.error_floor = 0.1; },
      [](auto& r) { r.thresholds.regions.clear(); },
      [](auto& r) { r.thresholds.regions.push_back(r.thresholds.regions[0]); },
      [](auto& r) { r.thresholds.regions[0].threshold = 0.25; },
      [](auto& r) {
        r.thresholds.regions[0].shape = BoxShape{{0, 0, 0}, {1, 1, 2}};
      },
      [](auto& r) {
        r.thresholds.regions[0].shape = BallShape{{0, 0, 0}, 1};
      },
      [](auto& r) {
        r.thresholds.regions[0].shape = HalfSpaceShape{{0, 0, 0}, 1};
      },
      [](auto& r) { r.thresholds.grid = nullptr; },
      [](auto& r) {
        r.thresholds.grid = grid({1, 3});
      },
      [](auto& r) {
        r.thresholds.grid = grid({1, 2}, {1, 2, 1});
      },
      [](auto& r) {
        r.thresholds.grid = grid({1, std::nanf("")});
      },
      [](auto& r) { r.thresholds.view.reset(); },
      [](auto& r) { r.thresholds.view->eye[2] = 4; },
      [](auto& r) { r.thresholds.view->field_of_view = 31; },
      [](auto& r) { r.thresholds.view->height_pixels = 601; },
      [](auto& r) { r.thresholds.view->tolerance_pixels = 2; },
      [](auto& r) { r.thresholds.view->frustum.reset(); },
      [](auto& r) { r.thresholds.view->frustum->look_at[0] = 5; },
      [](auto& r) {
        r.thresholds.view->frustum->up = {0, 1, 0};
      },
      [](auto& r) { r.thresholds.view->frustum->aspect = 2; },
      [](auto& r) { r.thresholds.view->frustum->outside = 3; },
  };
  std::map<std::string, std::size_t> seen;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    IsosurfaceRequest request = full();
    changes[i](request);
    const auto [there, is_new] = seen.emplace(key_of(request), i);
    EXPECT_TRUE(is_new) << "changes " << there->second << " and " << i;
  }
}

TEST(RequestKey, IsEqualForEqualRequests) {
  EXPECT_EQ(key_of(full()), key_of(full()));
  IsosurfaceRequest zero = full();
  zero.isovalue = 0.0;
  IsosurfaceRequest negative_zero = full();
  negative_zero.isovalue = -0.0;
  EXPECT_EQ(zero, negative_zero);
  EXPECT_EQ(key_of(zero), key_of(negative_zero));
  IsosurfaceRequest silent = full();
  silent.thresholds.grid = grid({1, std::numeric_limits<float>::quiet_NaN()});
  IsosurfaceRequest silent_too = full();
  silent_too.thresholds.grid = grid({1, -std::numeric_limits<float>::quiet_NaN()});
  EXPECT_EQ(silent, silent_too);
  EXPECT_EQ(key_of(silent), key_of(silent_too));
}

TEST(RequestKey, DiffersForAReplacedDataset) {
  DatasetInfo info;
  info.name = "head";
  info.content_id = 7;
  const std::string key = key_of(info);
  EXPECT_EQ(key_of(DatasetInfo(info)), key);
  const std::vector<std::function<void(DatasetInfo&)>> changes = {
      [](DatasetInfo& i) { i.content_id = 8; },
      [](DatasetInfo& i) { i.name = "tooth"; },
      [](DatasetInfo& i) { i.index_to_world.translation[1] = 3; },
      [](DatasetInfo& i) { i.index_to_world.columns[2][2] = 3; },
      [](DatasetInfo& i) { i.outside = 0; },
      [](DatasetInfo& i) { i.margin = 1; },
      [](DatasetInfo& i) { i.meaning.length_unit = "mm"; },
      [](DatasetInfo& i) { i.meaning.space = WorldSpace::kRas; },
      [](DatasetInfo& i) { i.meaning.assumed = "spacing along z"; },
      [](DatasetInfo& i) {
        i.member = SeriesMember{.series = "teeth", .label = Label{.value = 3}};
      },
      [](DatasetInfo& i) { i.dims[0] = 4; }};
  for (const auto& change : changes) {
    DatasetInfo other = info;
    change(other);
    EXPECT_NE(key_of(other), key);
  }
}

}  // namespace
}  // namespace multitetra
