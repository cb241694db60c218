// Several surfaces in one file, and surfaces colored by a field, over HTTP.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstring>

#include "common/json/json_report.hpp"
#include "tests/support/fake_steps.hpp"
#include "tests/support/fields.hpp"
#include "tests/support/running_http_server.hpp"
#include "tests/support/served_datasets.hpp"

namespace multitetra {
namespace {

using testing::HttpClient;
using testing::RunningHttpServer;

CataloguePtr ball_and_height() {
  Volume height =
      testing::fields::sampled<std::uint8_t>({40, 40, 40}, [](int, int, int z) { return 5 * z; });
  return testing::catalogue_with({make_dataset(testing::fields::ball({33, 33, 33}, 12), "ball"),
                                  make_dataset(std::move(height), "height")});
}

class SceneTest : public ::testing::Test {
 protected:
  [[nodiscard]] HttpClient::Response get(const std::string& query) {
    return client_.get("/v1/datasets/ball/isosurface?" + query);
  }
  void expect_refused(const std::string& query, const std::string& text, unsigned status = 400) {
    const auto response = get(query);
    EXPECT_EQ(response.result_int(), status) << query;
    EXPECT_NE(response.body().find(text), std::string::npos) << query << ": " << response.body();
  }
  static Json json_of_glb(const std::string& file) {
    std::uint32_t length = 0;
    std::memcpy(&length, file.data() + 12, sizeof length);
    return Json::parse(file.substr(20, length));
  }

  RunningHttpServer server_{ball_and_height()};
  HttpClient client_{server_.http()};
};

TEST_F(SceneTest, NamesThePartsOfSeveralIsovalues) {
  const auto response = get("isovalue=-2,0,2.5&error=0.5");
  ASSERT_EQ(response.result_int(), 200U) << response.body();
  EXPECT_EQ(response["Multitetra-Components"], "3");
  EXPECT_EQ(response["Multitetra-Euler-Characteristic"], "6");
  const Json gltf = json_of_glb(response.body());
  ASSERT_EQ(gltf.at("nodes").size(), 3U);
  EXPECT_EQ(gltf.at("nodes")[0].at("name"), "isovalue -2");
  EXPECT_EQ(gltf.at("nodes")[2].at("name"), "isovalue 2.5");
  EXPECT_EQ(gltf.at("materials").size(), 3U);
  EXPECT_NE(gltf.at("materials")[0], gltf.at("materials")[1]);
  EXPECT_EQ(gltf.at("scenes")[0].at("nodes"), (Json{0, 1, 2}));
}

TEST_F(SceneTest, RemovesSmallComponentsOnRequest) {
  const auto whole = get("isovalue=-2,2.5&error=0");  // Balls of two sizes.
  EXPECT_EQ(whole["Multitetra-Components-Written"], "2");
  const auto large = get("isovalue=-2,2.5&error=0&min_component=40");
  ASSERT_EQ(large.result_int(), 200U) << large.body();
  EXPECT_EQ(large["Multitetra-Components"], "2");
  EXPECT_EQ(large["Multitetra-Components-Written"], "1");
  EXPECT_EQ(large["Multitetra-Content-Digest"], whole["Multitetra-Content-Digest"]);
  EXPECT_EQ(json_of_glb(large.body()).at("nodes").size(), 1U);
  const auto none = get("isovalue=0&error=0.5&min_component=1000");
  ASSERT_EQ(none.result_int(), 200U) << "as an empty isosurface";
  EXPECT_NE(none["Multitetra-Notice"].find("min_component removes all its components"),
            std::string::npos);
  expect_refused("min_component=-1", "from 0 to 1e6");
  expect_refused("min_component=x", "min_component");
}

TEST_F(SceneTest, SharesABudgetAmongSurfaces) {
  const auto plain = get("isovalue=-2,2&error=0.05");
  const auto response = get("isovalue=-2,2&error=0.05&max_triangles=300");
  ASSERT_EQ(response.result_int(), 200U) << response.body();
  EXPECT_GT(std::stoi(std::string(plain["Multitetra-Triangles"])), 300);
  EXPECT_LE(std::stoi(std::string(response["Multitetra-Triangles"])), 300);
  expect_refused("isovalue=-2,2&max_triangles=1", "cannot be shared");
}

TEST_F(SceneTest, ColorsASurfaceByAField) {
  const auto ply = get("isovalue=0&error=0.5&color_by=height&colors=gray&format=ply");
  ASSERT_EQ(ply.result_int(), 200U) << ply.body();
  EXPECT_NE(ply.body().find("property float scalar\nproperty uchar red"), std::string::npos);
  const std::string file = ply.body();
  const std::size_t data = file.find("end_header\n") + 11;
  float z = 0;
  float scalar = 0;
  std::memcpy(&z, file.data() + data + 8, sizeof z);
  std::memcpy(&scalar, file.data() + data + 12, sizeof scalar);
  EXPECT_NEAR(scalar, 5 * z, 0.01);
  const auto red = static_cast<unsigned char>(file[data + 16]);
  EXPECT_NEAR(red, 255 * 5 * z / 195, 1);
  const Json gltf = json_of_glb(get("isovalue=0&error=0.5&color_by=height").body());
  const Json& attributes = gltf.at("meshes")[0].at("primitives")[0].at("attributes");
  EXPECT_TRUE(attributes.contains("COLOR_0") && attributes.contains("_SCALAR"));
  const auto log =
      get("isovalue=0&error=0.5&color_by=height&colors=gray&format=ply&color_range=1,100&"
          "color_scale=log");
  ASSERT_EQ(log.result_int(), 200U) << log.body();
  const std::string logarithmic = log.body();
  std::memcpy(&scalar, logarithmic.data() + logarithmic.find("end_header\n") + 23, sizeof scalar);
  const auto gray = static_cast<unsigned char>(logarithmic[logarithmic.find("end_header\n") + 27]);
  EXPECT_EQ(gray, color_at(ColorMap::kGray, std::log(scalar) / std::log(100.0))[0]);
  EXPECT_NE(get("isovalue=0&error=0.5&color_by=height&format=vtp").body().find("Scalars="),
            std::string::npos);
  for (const std::string format : {"stl", "3mf", "obj", "drc"}) {
    const auto response = get("isovalue=0&error=0.5&color_by=height&format=" + format);
    EXPECT_EQ(response["Multitetra-Notice"],
              "." + format +
                  " files have no values and colors of vertices; .ply, .glb and .vtp files have "
                  "them.");
  }
  EXPECT_EQ(get("isovalue=0&error=0.5&format=stl")["Multitetra-Notice"], "");
}

TEST_F(SceneTest, ABudgetOfBytesIsOneOfTheFile) {
  for (const char* const format : {"glb", "ply", "stl", "obj", "drc", "vtp", "3mf"}) {
    const std::string query = std::string("isovalue=0&error=0&format=") + format;
    const std::size_t whole = get(query).body().size();
    const std::size_t most = whole / 2;
    const auto response = get(query + "&max_bytes=" + std::to_string(most));
    ASSERT_EQ(response.result_int(), 200U) << response.body();
    EXPECT_LE(response.body().size(), most) << format;
    EXPECT_GT(response.body().size(), most / 2) << format;
  }
  EXPECT_LE(get("isovalue=0&error=0&codec=meshopt&max_bytes=10KB").body().size(), 10U << 10);
  EXPECT_LE(get("isovalue=-2,2&error=0&max_bytes=30KB").body().size(), 30U << 10);
  expect_refused("isovalue=0&error=0&format=ply&max_bytes=100", "100 bytes", 422);
}

TEST_F(SceneTest, CompressesGlbWithMeshopt) {
  const auto plain = get("isovalue=0&error=0.5&normals=8");
  const auto packed = get("isovalue=0&error=0.5&normals=8&codec=meshopt");
  ASSERT_EQ(packed.result_int(), 200U) << packed.body();
  EXPECT_LT(2 * packed.body().size(), plain.body().size()) << "of few triangles";
  EXPECT_NE(packed["ETag"], plain["ETag"]);
  EXPECT_GT(std::stod(std::string(packed["Multitetra-Error-Bound"])),
            std::stod(std::string(plain["Multitetra-Error-Bound"])));
  EXPECT_EQ(json_of_glb(packed.body()).at("extensionsRequired"),
            (Json{"EXT_meshopt_compression", "KHR_mesh_quantization"}));
  expect_refused("isovalue=0&format=stl&codec=meshopt", "compresses GLB files alone");
  expect_refused("isovalue=0&codec=zip", "none or meshopt");
}

TEST_F(SceneTest, NotesCavitiesThatRemovalFills) {
  Volume shell = testing::fields::sampled<float>({40, 40, 40}, [](int x, int y, int z) {
    const double radius = std::hypot(x - 20, y - 20, z - 20);
    return static_cast<float>(10 - std::abs(radius - 10));
  });
  RunningHttpServer server(testing::catalogue_with({make_dataset(std::move(shell), "shell")}));
  HttpClient client(server.http());
  const auto response =
      client.get("/v1/datasets/shell/isosurface?isovalue=5&error=0&min_component=largest");
  const std::string notice(response["Multitetra-Notice"]);
  EXPECT_NE(notice.find("removal fills 1 cavity, whose wall is a component: 5"), std::string::npos)
      << "a ball of radius 5 has a volume of 524: " << notice;
}

TEST_F(SceneTest, CountsTheVerticesWithoutAColor) {
  RunningHttpServer server(
      testing::catalogue_with({make_dataset(testing::fields::ball({33, 33, 33}, 12), "ball"),
                               make_dataset(testing::fields::ball({17, 33, 33}, 12), "half"),
                               make_dataset(testing::fields::ball({2, 2, 2}, 12), "corner")}));
  HttpClient client(server.http());
  const auto notice = [&](const std::string& field) {
    return std::string(client.get("/v1/datasets/ball/isosurface?isovalue=0&error=0.5&color_by=" +
                                  field)["Multitetra-Notice"]);
  };
  EXPECT_EQ(notice("ball"), "");
  EXPECT_NE(notice("half").find(" % of the vertices have no value of \"half\""), std::string::npos)
      << notice("half");
  EXPECT_NE(notice("corner").find("All vertices have no value"), std::string::npos)
      << notice("corner");
}

TEST_F(SceneTest, NamesInvalidParameters) {
  expect_refused("isovalue=1,2&format=ply", "require format=glb");
  expect_refused("isovalue=1,,2", "A,B,C");
  expect_refused("isovalue=1&color_by=nothing", "No dataset", 404);
  expect_refused("isovalue=1&color_range=1,2", "need color_by");
  expect_refused("isovalue=1&color_scale=log", "need color_by");
  expect_refused("isovalue=1&color_by=height&color_scale=log", "both above 0");
  expect_refused("isovalue=1&color_by=height&color_scale=square", "linear or log");
  expect_refused("isovalue=1&color_by=height&no_value_color=red", "RRGGBB");
  expect_refused("isovalue=1&color_by=height&color_range=2,1", "in increasing order");
  expect_refused("isovalue=1&color_by=height&colors=jet", "viridis");
}

// A file that was made for one client is cached for all.
TEST(SceneRights, HoldForFilesThatAreCached) {
  AccessRights meshes_alone("bob", {"*"});
  meshes_alone.allow_surfaces_only();
  auto access = std::make_shared<AccessList>();
  access->add({.digest = digest_of_token("all"), .rights = AccessRights("alice", {"*"})});
  access->add({.digest = digest_of_token("meshes"), .rights = meshes_alone});
  RunningHttpServer server(ball_and_height(), {}, {.admission = {.access = access}});
  HttpClient client(server.http());
  const std::string file = "/v1/datasets/ball/isosurface?isovalue=0&error=0.5&color_by=height";
  const auto made = client.get(file, "Authorization: Bearer all\r\n");
  ASSERT_EQ(made.result_int(), 200U) << made.body();
  const std::string mine = "Authorization: Bearer meshes\r\n";
  EXPECT_EQ(client.get(file, mine).result_int(), 403U);
  const std::string tag = std::string(made["ETag"]);
  ASSERT_FALSE(tag.empty());
  EXPECT_EQ(client.get(file, mine + "If-None-Match: " + tag + "\r\n").result_int(), 403U);
}

}  // namespace
}  // namespace multitetra
