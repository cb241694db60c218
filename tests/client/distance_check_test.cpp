// The full check against surfaces of the real server, and against wrong ones.
#include "client/distance_check.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "client/full_resolution_surface.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "tests/support/prepared_fields.hpp"

namespace multitetra {
namespace {

namespace fields = testing::fields;
using testing::PreparedSetting;

std::vector<float> samples_of(const Volume& volume) {
  return std::visit([](const auto& s) { return std::vector<float>(s.begin(), s.end()); },
                    volume.samples);
}

CommittedStep step_of(const DatasetPtr& dataset, const IsosurfaceRequest& request) {
  const TiledSurface surface = SurfaceExtractor(dataset).extract({.request = request});
  std::vector<const LatticeMesh*> tiles;
  for (const TileMesh& tile : surface.tiles) tiles.push_back(&tile.mesh);
  CommittedStep step;
  step.begin.is_final = true;
  step.begin.request = request;
  step.mesh = weld(tiles, request.lattice_resolution);
  return step;
}

double area(const std::vector<SurfaceTriangle>& surface) {
  double sum = 0;
  for (const SurfaceTriangle& t : surface) {
    Vec3 a;
    Vec3 b;
    for (std::size_t i = 0; i < 3; ++i) a[i] = t[1][i] - t[0][i], b[i] = t[2][i] - t[0][i];
    const Vec3 n = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                    a[0] * b[1] - a[1] * b[0]};
    sum += 0.5 * std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  }
  return sum;
}

DatasetInfo info_of(const Volume& volume) {
  DatasetInfo info;
  info.dims = volume.dims;
  info.spacing = volume.spacing;
  info.index_to_world = volume.index_to_world;
  info.grid_exponent = grid_exponent_for(volume.dims, 0);
  return info;
}

// ---- the full-resolution surface by itself

TEST(FullResolutionSurface, OfALinearFieldIsAPlane) {
  const Volume volume = fields::sampled<float>(
      {9, 7, 12}, [](int x, int y, int z) { return 2 * x + 3 * y + 6 * z; }, {1, 2, 0.5});
  const auto surface = full_resolution_surface(info_of(volume), samples_of(volume), 30.25);
  ASSERT_FALSE(surface.empty());
  for (const SurfaceTriangle& t : surface) {
    for (const Vec3& p : t) ASSERT_NEAR(2 * p[0] + 1.5 * p[1] + 12 * p[2], 30.25, 1e-12);
  }
}

// The tetrahedra fill the data and do not overlap.
TEST(FullResolutionSurface, OfAPlaneAcrossTheDataHasItsArea) {
  for (const std::array<std::int32_t, 3> dims :
       {std::array<std::int32_t, 3>{9, 9, 9}, {8, 6, 7}, {17, 3, 2}}) {
    const Volume volume = fields::sampled<float>(dims, [](int x, int, int) { return x; });
    const auto surface = full_resolution_surface(info_of(volume), samples_of(volume), 0.3);
    EXPECT_NEAR(area(surface), (dims[1] - 1) * (dims[2] - 1), 1e-9) << dims[0];
  }
}

TEST(FullResolutionSurface, EndsAtVoidAndClosesAtAValue) {
  Volume volume = fields::sampled<float>({5, 5, 5}, [](int, int, int) { return 1; });
  DatasetInfo info = info_of(volume);
  EXPECT_TRUE(full_resolution_surface(info, samples_of(volume), 0.5).empty());
  info.margin = 1;
  info.outside = 0;
  info.grid_exponent = grid_exponent_for(volume.dims, 1);
  const auto closed = full_resolution_surface(info, samples_of(volume), 0.5);
  EXPECT_GT(area(closed), 6 * 4 * 4);
  EXPECT_LE(area(closed), 6 * 5 * 5 + 1e-9);
}

TEST(Snapping, IsAStepAlongTheLongestDiagonal) {
  DatasetInfo info;
  EXPECT_DOUBLE_EQ(snapping_world(info, 5), std::sqrt(3.0) / 32);
  info.index_to_world.columns = {Vec3{1, 0, 0}, Vec3{0, 2, 0}, Vec3{0, 0, 2}};
  EXPECT_DOUBLE_EQ(snapping_world(info, 1), 1.5);
  info.index_to_world.columns = {Vec3{1, 0, 0}, Vec3{1, 1, 0}, Vec3{0, 0, 1}};
  EXPECT_DOUBLE_EQ(snapping_world(info, 1), std::sqrt(6.0) / 2) << "sheared";
}

// ---- the server's surfaces

class DistanceCheckOf : public ::testing::TestWithParam<PreparedSetting> {};

TEST_P(DistanceCheckOf, ACertifiedSurfaceIsWithinItsBoundBothWays) {
  const PreparedSetting& setting = GetParam();
  const DatasetPtr dataset = prepared(setting);
  const auto samples = samples_of(setting.volume);
  // Through the middle of the values, and at an edge of the spectrum's bins.
  const auto all = testing::isovalues_of(*dataset);
  for (const double isovalue : {all[1], all.back()}) {
    for (const auto& [error, resolution] : {std::pair(0.0, 5), {0.5, 2}, {2.0, 5}}) {
      SCOPED_TRACE(::testing::Message() << "isovalue " << isovalue << ", error " << error);
      const IsosurfaceRequest request = {
          .isovalue = isovalue, .error = error, .lattice_resolution = resolution};
      const DistanceCheck check =
          check_distances(step_of(dataset, request), dataset->info, samples, {.samples = 400});
      ASSERT_TRUE(check.promise);
      EXPECT_TRUE(check.has_passed())
          << check.mesh_to_full.maximum << " and " << check.full_to_mesh.maximum << ", allowed "
          << check.promise->threshold + check.promise->snapping;
    }
  }
}

std::string setting_name(const ::testing::TestParamInfo<PreparedSetting>& parameter) {
  return parameter.param.name;
}
INSTANTIATE_TEST_SUITE_P(All, DistanceCheckOf, ::testing::ValuesIn(testing::prepared_settings()),
                         setting_name);

// ---- wrong surfaces

class WrongSurface : public ::testing::Test {
 protected:
  [[nodiscard]] DistanceCheck checked(const CommittedStep& step) const {
    return check_distances(step, dataset_->info, samples_of(volume_), {.samples = 2000});
  }

  Volume volume_ = fields::gyroid(25, 0.1, 3);
  DatasetPtr dataset_ = make_dataset(volume_, "gyroid");
  CommittedStep step_ = step_of(dataset_, {.isovalue = 0.1, .error = 0.5});
};

TEST_F(WrongSurface, TheRightOnePasses) { EXPECT_TRUE(checked(step_).has_passed()); }

TEST_F(WrongSurface, OneThatWasMovedIsFound) {
  for (LatticePoint& vertex : step_.mesh.vertices) vertex.x += 32;
  EXPECT_FALSE(checked(step_).has_passed());
}

TEST_F(WrongSurface, OneWithoutAPartIsFoundFromTheOtherSide) {
  auto& triangles = step_.mesh.triangles;
  triangles.resize(triangles.size() - triangles.size() / 8);
  const DistanceCheck check = checked(step_);
  EXPECT_EQ(check.mesh_to_full.above_limit, 0U);
  EXPECT_GT(check.full_to_mesh.above_limit, 0U);
  EXPECT_FALSE(check.has_passed());
}

TEST_F(WrongSurface, OneOfALargerErrorIsFound) {
  CommittedStep coarse = step_of(dataset_, {.isovalue = 0.1, .error = 4});
  coarse.begin.request.error = 0.05;
  EXPECT_FALSE(checked(coarse).has_passed());
}

// Of a budget the server raises the floor of thresholds; with a map the largest one counts.
TEST_F(WrongSurface, WhatIsAllowedCountsWhereverItIsSaid) {
  CommittedStep raised = step_of(dataset_, {.isovalue = 0.1, .error = 2});
  raised.begin.request.error = 0.05;
  EXPECT_FALSE(checked(raised).has_passed());
  raised.begin.request.thresholds.at_least = 2;
  EXPECT_TRUE(checked(raised).has_passed());
  CommittedStep mapped = step_of(dataset_, {.isovalue = 0.1, .error = 2});
  mapped.begin.request.error = 0.05;
  mapped.begin.request.thresholds.regions = {{.shape = BallShape{}, .threshold = 2}};
  mapped.begin.error_bound_world = 2;
  EXPECT_TRUE(checked(mapped).has_passed());
}

TEST_F(WrongSurface, AnEmptyOneIsFound) {
  step_.mesh = {};
  EXPECT_FALSE(checked(step_).has_passed());
}

TEST_F(WrongSurface, WhereNothingIsPromisedNothingIsFound) {
  for (LatticePoint& vertex : step_.mesh.vertices) vertex.x += 32;
  CommittedStep paper = step_;
  paper.begin.request.measure = ErrorMeasure::kPaper;
  EXPECT_FALSE(checked(paper).promise);
  EXPECT_TRUE(checked(paper).has_passed());
  CommittedStep tolerant = step_;
  tolerant.begin.request.topology_tolerance = 1;
  EXPECT_FALSE(checked(tolerant).promise);
  EXPECT_GT(checked(tolerant).mesh_to_full.maximum, 0.5) << "it is measured all the same";
}

}  // namespace
}  // namespace multitetra
