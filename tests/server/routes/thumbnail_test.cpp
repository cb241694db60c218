// Thumbnails over HTTP.
#include <png.h>

#include <algorithm>

#include <gtest/gtest.h>

#include "tests/support/fields.hpp"
#include "tests/support/running_http_server.hpp"
#include "tests/support/served_datasets.hpp"

namespace multitetra {
namespace {

using testing::HttpClient;
using testing::RunningHttpServer;

// Opacities of all pixels, row by row.
std::vector<std::uint8_t> opacities(const std::string& file) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_memory(&image, file.data(), file.size()), 0);
  EXPECT_EQ(image.width, 128U);
  EXPECT_EQ(image.height, 96U);
  image.format = PNG_FORMAT_RGBA;
  std::vector<std::uint8_t> pixels(PNG_IMAGE_SIZE(image));
  EXPECT_NE(png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr), 0);
  std::vector<std::uint8_t> found;
  for (std::size_t at = 3; at < pixels.size(); at += 4) found.push_back(pixels[at]);
  return found;
}

std::size_t opaque(const std::vector<std::uint8_t>& pixels) {
  return static_cast<std::size_t>(std::count(pixels.begin(), pixels.end(), 255));
}

// An ellipsoid that is long along z.
Volume ellipsoid() {
  return testing::fields::sampled<std::int16_t>({65, 65, 65}, [](int x, int y, int z) {
    const double across = (x - 32) * (x - 32) + (y - 32) * (y - 32);
    return 1000 - across - 0.1 * (z - 32) * (z - 32);
  });
}

class ThumbnailTest : public ::testing::Test {
 protected:
  [[nodiscard]] http::response<http::string_body> get(const std::string& query,
                                                      const std::string& fields = {}) {
    return client_.get("/v1/datasets/long/thumbnail.png" + query, fields);
  }
  RunningHttpServer server_{testing::catalogue_with({make_dataset(ellipsoid(), "long")})};
  HttpClient client_{server_.http()};
};

// As <img> on a page of another site, which sends no Origin.
TEST_F(ThumbnailTest, IsRefusedToPagesOfOtherSites) {
  for (const char* const site : {"same-origin", "none", "same-site"}) {
    EXPECT_EQ(get("?isovalue=850.5", "Sec-Fetch-Site: " + std::string(site) + "\r\n").result_int(),
              200U);
  }
  const auto refused = get("?isovalue=850.5", "Sec-Fetch-Site: cross-site\r\n");
  EXPECT_EQ(refused.result_int(), 403U);
  EXPECT_EQ(refused["Cross-Origin-Resource-Policy"], "same-origin");
  HttpOptions options;
  options.allowed_origins = {"https://a.example"};
  RunningHttpServer server(testing::catalogue_with({make_dataset(ellipsoid(), "long")}), options);
  HttpClient client(server.http());
  const auto from = [&](const std::string& origin) {
    return client.get("/v1/datasets/long",
                      "Sec-Fetch-Site: cross-site\r\nOrigin: " + origin + "\r\n");
  };
  EXPECT_EQ(from("https://b.example").result_int(), 403U);
  EXPECT_EQ(from("https://a.example").result_int(), 200U);
  EXPECT_EQ(from("https://a.example")["Cross-Origin-Resource-Policy"], "cross-origin");
}

TEST_F(ThumbnailTest, ShowsTheSurfaceOnTransparentGround) {
  const auto response = get("?isovalue=850.5");
  ASSERT_EQ(response.result_int(), 200U) << response.body();
  EXPECT_EQ(response[http::field::content_type], "image/png");
  const std::vector<std::uint8_t> pixels = opacities(response.body());
  EXPECT_EQ(pixels[48 * 128 + 64], 255) << "the middle";
  EXPECT_EQ(pixels[0], 0) << "a corner";
  EXPECT_EQ(get("?isovalue=850.5").body(), response.body());
}

TEST_F(ThumbnailTest, TurnsAnotherAxisUp) {
  const std::size_t upright = opaque(opacities(get("?isovalue=850.5").body()));
  const std::size_t lying = opaque(opacities(get("?isovalue=850.5&up=y").body()));
  EXPECT_NE(upright, lying) << "the picture is wider than high";
}

TEST_F(ThumbnailTest, ShowsTheSuggestedIsovalueByDefault) {
  EXPECT_GT(opaque(opacities(get("").body())), 100U);
  EXPECT_EQ(opaque(opacities(get("?isovalue=5000").body())), 0U) << "there is no surface";
}

TEST_F(ThumbnailTest, IsCheckedAgainByItsTag) {
  const auto response = get("");
  const std::string tag(response[http::field::etag]);
  ASSERT_FALSE(tag.empty());
  EXPECT_EQ(get("", "If-None-Match: " + tag + "\r\n").result_int(), 304U);
  EXPECT_EQ(get("?up=y", "If-None-Match: " + tag + "\r\n").result_int(), 200U);
}

TEST_F(ThumbnailTest, RejectsInvalidQueries) {
  for (const auto& [query, text] : {std::pair{"?up=w", "must be x, -x, y, -y, z or -z"},
                                    {"?isovalue=nan", "must be a finite number"},
                                    {"?width=9", "valid parameters: isovalue, up"}}) {
    const auto response = get(query);
    EXPECT_EQ(response.result_int(), 400U) << query;
    EXPECT_NE(response.body().find(text), std::string::npos) << response.body();
  }
}

}  // namespace
}  // namespace multitetra
