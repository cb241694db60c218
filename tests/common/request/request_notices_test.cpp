#include "common/request/request_notices.hpp"

#include <gtest/gtest.h>

namespace multitetra {
namespace {

// 11 x 11 x 11 samples, two world units apart, from (100, 0, -20) on, with values from 0 to 255.
DatasetInfo far_away() {
  DatasetInfo info;
  info.name = "ct";
  info.dims = {11, 11, 11};
  info.spacing = {2, 2, 2};
  info.index_to_world = {.columns = {Vec3{2, 0, 0}, Vec3{0, 2, 0}, Vec3{0, 0, 2}},
                         .translation = {100, 0, -20}};
  info.max = 255;
  return info;
}

IsosurfaceRequest with(decltype(ThresholdRegion::shape) shape,
                       CoordinateSystem coordinates = CoordinateSystem::kWorld) {
  IsosurfaceRequest request{.isovalue = 60};
  request.thresholds.coordinates = coordinates;
  request.thresholds.regions = {{.shape = shape, .threshold = 0.5}};
  return request;
}

std::string notices_of(const IsosurfaceRequest& request, const DatasetInfo& info = far_away()) {
  std::string text;
  for (const std::string& notice : request_notices(request, info)) text += notice + "\n";
  return text;
}

TEST(RequestNotices, AreNoneForASurfaceInsideTheData) {
  EXPECT_EQ(notices_of({.isovalue = 60}), "");
  EXPECT_EQ(notices_of(with(BoxShape{.low = {90, -5, -30}, .high = {101, 1, -19}})), "");
  EXPECT_EQ(notices_of(with(BallShape{.center = {99, 0, -20}, .radius = 0.5})), "")
      << "one sample away";
  EXPECT_EQ(notices_of(with(HalfSpaceShape{.normal = {1, 0, 0}, .offset = 119})), "");
  EXPECT_EQ(notices_of(with(BallShape{.center = {5, 5, 5}}, CoordinateSystem::kIndex)), "");
}

TEST(RequestNotices, WarnAboutRegionsOutsideTheData) {
  const std::string where =
      "Region 1 is outside \"ct\" and without effect: its samples range from (100, 0, -20) to "
      "(120, 20, 0) in world coordinates.\n";
  EXPECT_EQ(notices_of(with(BoxShape{.low = {0, 0, 0}, .high = {10, 10, 10}})), where);
  EXPECT_EQ(notices_of(with(BallShape{.center = {126, 24, 4}, .radius = 4})), where)
      << "off a corner";
  EXPECT_EQ(notices_of(with(HalfSpaceShape{.normal = {-1, 0, 0}, .offset = 0})), where);
  EXPECT_EQ(
      notices_of(with(BallShape{.center = {110, 10, -10}, .radius = 5}, CoordinateSystem::kIndex)),
      "Region 1 is outside \"ct\" and without effect: its samples range from (0, 0, 0) to (10, 10, "
      "10) in sample indices.\n");
}

TEST(RequestNotices, WarnAboutABudgetThatRaisedTheError) {
  IsosurfaceRequest served{.isovalue = 60, .error = 0.5, .max_bytes = 1000};
  served.thresholds.error_floor = 36;
  EXPECT_EQ(notices_of(served), "The budget raised the error from 0.5 to 36 voxels.\n");
  served.unit = ErrorUnit::kWorld;
  EXPECT_EQ(notices_of(served), "The budget raised the error from 0.5 to 36 units.\n");
  served.thresholds.error_floor = 1;
  EXPECT_EQ(notices_of(served), "") << "at most twice the error";
  served.error = 0;
  EXPECT_EQ(notices_of(served), "") << "the best that fits";
}

TEST(RequestNotices, CountManyRegionsInOneSentence) {
  IsosurfaceRequest request = with(BallShape{.center = {110, 10, -10}});
  for (int i = 0; i < 5; ++i) request.thresholds.regions.push_back({.shape = BallShape{}});
  EXPECT_EQ(notices_of(request).substr(0, 48), "5 regions, the first of them region 2, are outsi");
}

TEST(RequestNotices, WarnAboutABoxOutsideObliqueAxes) {
  DatasetInfo info = far_away();  // Rotated by 45 degrees about z.
  info.index_to_world = {.columns = {Vec3{1, 1, 0}, Vec3{-1, 1, 0}, Vec3{0, 0, 1}}};
  EXPECT_EQ(notices_of(with(BoxShape{.low = {-1, 9, 0}, .high = {1, 11, 1}}), info), "");
  EXPECT_NE(notices_of(with(BoxShape{.low = {8, 0, 0}, .high = {10, 2, 1}}), info), "")
      << "inside of the box around the data, beside the data";
}

TEST(RequestNotices, WarnAboutAGridOutsideTheData) {
  ThresholdGrid grid{.dims = {2, 1, 1}, .thresholds = {1, 2}};
  IsosurfaceRequest request{.isovalue = 60};
  request.thresholds.grid = std::make_shared<const ThresholdGrid>(grid);
  EXPECT_NE(notices_of(request).find("from (-0.5, -0.5, -0.5) to (1.5, 0.5, 0.5)"),
            std::string::npos);
  grid.index_to_world.translation = {110, 10, -10};
  request.thresholds.grid = std::make_shared<const ThresholdGrid>(grid);
  EXPECT_EQ(notices_of(request), "");
}

TEST(RequestNotices, WarnAboutAnIsovalueOutsideTheRange) {
  const std::string values = "; values of \"ct\" range from 0 to 255.\n";
  EXPECT_EQ(notices_of({.isovalue = 255}),
            "The surface is empty: there is no surface at isovalue 255" + values);
  EXPECT_EQ(notices_of({.isovalue = -0.5}),
            "The surface is empty: there is no surface at isovalue -0.5" + values);
  EXPECT_EQ(notices_of({.isovalue = 0}), "") << "A sample is positive when it is greater.";
  DatasetInfo closed = far_away();
  closed.outside = -1000;
  EXPECT_EQ(notices_of({.isovalue = -0.5}, closed), "") << "The surface closes around the data.";
}

}  // namespace
}  // namespace multitetra
