#include "common/request/threshold_parser.hpp"

#include <gtest/gtest.h>

namespace multitetra {
namespace {

TEST(ParseRegion, ReadsTheCornersOfABox) {
  const auto region = parse_region("box:2,0,-1.5,4,8,1e2=0.25");
  ASSERT_TRUE(region) << region.error().text;
  EXPECT_EQ(*region, (ThresholdRegion{.shape = BoxShape{.low = {2, 0, -1.5}, .high = {4, 8, 100}},
                                      .threshold = 0.25}));
}

TEST(ParseRegion, ReadsBallsAndHalfSpaces) {
  EXPECT_EQ(parse_region("ball:1,2,3,4=0").value(),
            (ThresholdRegion{.shape = BallShape{.center = {1, 2, 3}, .radius = 4}}));
  EXPECT_EQ(parse_region("halfspace:0,0,-1,7.5=2").value(),
            (ThresholdRegion{.shape = HalfSpaceShape{.normal = {0, 0, -1}, .offset = 7.5},
                             .threshold = 2}));
}

TEST(ParseRegion, QuotesAndExplainsErrors) {
  const auto expect_refused = [](const char* word, const char* problem) {
    const auto region = parse_region(word);
    ASSERT_FALSE(region) << word;
    EXPECT_EQ(region.error().code, ErrorCode::kInvalidArgument);
    EXPECT_NE(region.error().text.find(problem), std::string::npos) << region.error().text;
    EXPECT_NE(region.error().text.find("box:X0,Y0,Z0,X1,Y1,Z1=TAU"), std::string::npos);
  };
  expect_refused("", "does not begin with a shape");
  expect_refused("1,2,3,4=1", "does not begin with a shape");
  expect_refused("cone:1,2,3,4=1", "\"cone:1,2,3,4=1\" does not begin with a shape");
  expect_refused("ball:1,2,3,4", "has no threshold");
  expect_refused("ball:1,2,3,4=", "threshold that is not a number");
  expect_refused("ball:1,2,3,4=1mm", "threshold that is not a number");
  expect_refused("ball:1,2,x,4=1", "\"x\" instead of a number");
  expect_refused("ball:1,2,,4=1", "\"\" instead of a number");
  expect_refused("ball:1,2,3=1", "3 numbers before its threshold, not 4");
  expect_refused("box:1,2,3,4=1", "4 numbers before its threshold, not 6");
  expect_refused("box:4,0,0,2,8,9=1", "its low corner above its high corner along x");
  expect_refused("box:0,0,9,2,8,1=1", "its low corner above its high corner along z");
  expect_refused("halfspace:1,2,3,4,5=1", "5 numbers before its threshold, not 4");
}

TEST(ParseView, AcceptsItsPartsInAnyOrder) {
  const ThresholdView plain{
      .eye = {1, 2, 3}, .field_of_view = 45, .height_pixels = 600, .tolerance_pixels = 0.5};
  EXPECT_EQ(parse_view("eye=1,2,3,fov=45,height=600,pixels=0.5").value(), plain);
  EXPECT_EQ(parse_view("pixels=0.5,height=600,fov=45,eye=1,2,3").value(), plain);
  ThresholdView framed = plain;
  framed.frustum = Frustum{.look_at = {0, 0, 9}, .up = {0, 1, 0}, .aspect = 1.5, .outside = 8};
  EXPECT_EQ(parse_view("eye=1,2,3,fov=45,height=600,pixels=0.5,look=0,0,9,up=0,1,0,aspect=1.5,"
                       "outside=8")
                .value(),
            framed);
}

TEST(ParseView, ChoosesAnUpDirectionForViewsAlongZ) {
  const auto up = [](const char* look) {
    return parse_view(std::string("eye=1,2,3,fov=45,height=600,pixels=1,outside=2,look=") + look)
        .value()
        .frustum->up;
  };
  EXPECT_EQ(up("4,2,3"), (Vec3{0, 0, 1}));
  EXPECT_EQ(up("1,2,9"), (Vec3{0, 1, 0}));
}

TEST(ParseView, QuotesAndExplainsErrors) {
  const auto expect_refused = [](const char* word, const char* problem) {
    const auto view = parse_view(word);
    ASSERT_FALSE(view) << word;
    EXPECT_EQ(view.error().code, ErrorCode::kInvalidArgument);
    EXPECT_NE(view.error().text.find(problem), std::string::npos) << view.error().text;
    EXPECT_NE(view.error().text.find("eye=X,Y,Z"), std::string::npos);
  };
  expect_refused("", "instead of a number");
  expect_refused("1,2,3", "\"1\" instead of a number");
  expect_refused("eye=1,2,3,fov=45,height=600", "lacks \"pixels\"");
  expect_refused("eye=1,2,fov=45,height=600,pixels=1", "2 numbers for \"eye\", not 3");
  expect_refused("eye=1,2,3,fov=45,46,height=600,pixels=1", "2 numbers for \"fov\", not 1");
  expect_refused("eye=1,2,3,fov=wide,height=600,pixels=1", "\"wide\" instead of a number");
  expect_refused("eye=1,2,3,fov=45,fov=45,height=600,pixels=1", "\"fov\" twice");
  expect_refused("eye=1,2,3,fov=45,height=600,pixels=1,zoom=2", "unknown part \"zoom\"");
  expect_refused("eye=1,2,3,fov=45,height=600,pixels=1,aspect=2", "\"aspect\" without \"look\"");
  expect_refused("eye=1,2,3,fov=45,height=600,pixels=1,look=0,0,0", "\"look\" without \"outside\"");
}

}  // namespace
}  // namespace multitetra
