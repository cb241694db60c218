// Slices and probes over HTTP.
#include <png.h>

#include <cstring>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "common/json/json_report.hpp"
#include "tests/support/fake_steps.hpp"
#include "tests/support/fields.hpp"
#include "tests/support/running_http_server.hpp"
#include "tests/support/served_datasets.hpp"

namespace multitetra {
namespace {

using testing::HttpClient;
using testing::RunningHttpServer;

Volume numbered() {
  Volume volume = testing::fields::sampled<std::uint16_t>(
      {12, 10, 9}, [](int x, int y, int z) { return x + 20 * y + 400 * z; }, {1, 1, 2});
  std::get<std::vector<std::uint16_t>>(volume.samples).back() = 0;
  return volume;
}

class SliceTest : public ::testing::Test {
 protected:
  [[nodiscard]] http::response<http::string_body> get(const std::string& query) {
    return client_.get("/v1/datasets/numbers/" + query);
  }
  [[nodiscard]] std::vector<float> values(const std::string& query) {
    const auto response = get("slice?format=raw&" + query);
    EXPECT_EQ(response.result_int(), 200U) << response.body();
    std::vector<float> floats(response.body().size() / sizeof(float));
    std::memcpy(floats.data(), response.body().data(), response.body().size());
    return floats;
  }
  void expect_refused(const std::string& query, const std::string& text, unsigned status = 400) {
    const auto response = get(query);
    EXPECT_EQ(response.result_int(), status) << query;
    EXPECT_NE(response.body().find(text), std::string::npos) << query << ": " << response.body();
  }

  RunningHttpServer server_{testing::catalogue_with({make_dataset(numbered(), "numbers")})};
  HttpClient client_{server_.http()};
};

TEST_F(SliceTest, ReturnsTheSamplesOfALayerRowByRow) {
  const std::vector<float> layer = values("axis=z&at=3");
  ASSERT_EQ(layer.size(), 120U);
  for (std::size_t i = 0; i < layer.size(); ++i) {
    EXPECT_EQ(layer[i], static_cast<float>(i % 12 + 20 * (i / 12) + 1200));
  }
  EXPECT_EQ(values("").front(), 1600) << "the middle layer";
}

TEST_F(SliceTest, HasSquareWorldPixelsAndZUp) {
  const auto response = get("slice?axis=x&at=5&format=raw");
  EXPECT_EQ(response["Multitetra-Width"], "10");
  EXPECT_EQ(response["Multitetra-Height"], "17") << "eight steps of two units each";
  EXPECT_EQ(response["Multitetra-Origin"], "5,0,8");
  EXPECT_EQ(response["Multitetra-Right"], "0,1,0");
  EXPECT_EQ(response["Multitetra-Down"], "0,0,-0.5");
  const std::vector<float> pixels = values("axis=x&at=5");
  EXPECT_EQ(pixels[0], 5 + 8 * 400);
  EXPECT_EQ(pixels[10], 5 + 7.5F * 400);
}

TEST_F(SliceTest, AcceptsAPlaneByVectorsOrNormal) {
  const std::vector<float> vectors =
      values("origin=2,3,4&right=1,0,0&down=0,0,1&width=3&height=2&coordinates=index");
  EXPECT_EQ(vectors, (std::vector<float>{1662, 1663, 1664, 2062, 2063, 2064}));
  const std::vector<float> oblique = values("normal=0,0,1&center=5,4,8&extent=2,2&width=3");
  EXPECT_EQ(oblique, (std::vector<float>{1704, 1705, 1706, 1684, 1685, 1686, 1664, 1665, 1666}));
}

TEST_F(SliceTest, MapsTheWindowToBlackAndWhite) {
  const auto response = get("slice?axis=z&at=0&window=100&level=50");
  ASSERT_EQ(response.result_int(), 200U) << response.body();
  EXPECT_EQ(response[http::field::content_type], "image/png");
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  ASSERT_NE(
      png_image_begin_read_from_memory(&image, response.body().data(), response.body().size()), 0);
  image.format = PNG_FORMAT_RGBA;
  std::vector<std::uint8_t> pixels(PNG_IMAGE_SIZE(image));
  ASSERT_NE(png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr), 0);
  ASSERT_EQ(image.width, 12U);
  const auto pixel = [&](std::size_t x, std::size_t y) { return pixels[4 * (12 * y + x)]; };
  EXPECT_EQ(pixel(0, 0), 0);
  EXPECT_EQ(pixel(11, 2), std::lround(255 * 0.51));
  EXPECT_EQ(pixel(0, 5), 255);
  EXPECT_EQ(pixel(0, 9), 255) << "beyond the window";
}

TEST_F(SliceTest, ReturnsNoValueOutsideTheData) {
  EXPECT_TRUE(std::isnan(
      values("origin=-1,0,0&right=1,0,0&down=0,1,0&width=2&height=2&coordinates=index").front()));
}

TEST_F(SliceTest, NamesInvalidParameters) {
  expect_refused("slice?axis=q", "axis=q: must be x, y or z");
  expect_refused("slice?axis=z&at=9", "at=0 to 8");
  expect_refused("slice?axis=z&normal=0,0,1", "not by several of these");
  expect_refused("slice?center=1,2,3", "needs a normal");
  expect_refused("slice?normal=0,0,0", "no direction");
  expect_refused("slice?normal=0,0,1&up=0,0,2", "parallel to its normal");
  expect_refused("slice?normal=1,2", "three numbers");
  expect_refused("slice?normal=0,0,1&extent=-3", "greater than 0");
  expect_refused("slice?normal=0,0,1&extent=5,nan", "greater than 0");
  expect_refused("slice?normal=0,0,1&center=inf,0,0", "1e100");
  expect_refused("slice?origin=0,0,0&right=1,0,0", "needs all three");
  expect_refused("slice?window=0", "window=0");
  expect_refused("slice?width=1", "2 or more");
  expect_refused("slice?colors=jet", "gray, viridis");
  expect_refused("slice?color_scale=log&window=4&level=2", "above 0");
  expect_refused("slice?color_scale=root", "linear or log");
  expect_refused("slice?no_value_color=12345g", "RRGGBB");
  expect_refused("slice?at=nan", "at=0 to 8");
  expect_refused("slice?normal=nan,0,1", "no direction");
  expect_refused("slice?origin=nan,0,0&right=1,0,0&down=0,1,0&width=2&height=2", "1e100");
  expect_refused("slice?width=1500&height=1500&normal=0,0,1&extent=9", "pixels", 422);
  expect_refused("probe", "at=X,Y,Z");
}

TEST_F(SliceTest, ReturnsValueAndGradientAtAPoint) {
  const auto response = get("probe?at=2.5,3,8&at=99,0,0");
  ASSERT_EQ(response.result_int(), 200U) << response.body();
  const Json places = Json::parse(response.body()).at("places");
  ASSERT_EQ(places.size(), 2U);
  EXPECT_EQ(places[0].at("value"), 1662.5);
  EXPECT_EQ(places[0].at("index"), (Json{2.5, 3.0, 4.0}));
  EXPECT_EQ(places[0].at("gradient"), (Json{1.0, 20.0, 200.0}));
  EXPECT_TRUE(places[1].at("value").is_null() && places[1].at("gradient").is_null());
}

}  // namespace
}  // namespace multitetra
