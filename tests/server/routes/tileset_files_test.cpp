// Tilesets over HTTP.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <atomic>
#include <chrono>
#include <cstring>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "common/mesh/mesh_checks.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "server/routes/path_pattern.hpp"
#include "server/service/caching_surface_provider.hpp"
#include "server/tilesets/neuroglancer.hpp"
#include "tests/support/fake_steps.hpp"
#include "tests/support/glb_reader.hpp"
#include "tests/support/prepared_fields.hpp"
#include "tests/support/running_http_server.hpp"
#include "tests/support/served_datasets.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

using testing::error_code_of;
using testing::HttpClient;
using testing::RunningHttpServer;

constexpr double kIsovalue = 0.1;
const std::string kFolder = "/v1/3dtiles/gyroid/iso/0.1/";

DatasetPtr gyroid() {
  static const DatasetPtr dataset = [] {
    auto described = std::make_shared<PreparedVolume>(
        *testing::prepared({"gyroid", testing::fields::gyroid(90, 0.1, 8)}));
    described->info.content_id = 7;
    return described;
  }();
  return dataset;
}
CataloguePtr gyroid_catalogue() { return testing::catalogue_with({gyroid()}); }

class TilesetFiles : public ::testing::Test {
 protected:
  nlohmann::json tileset(const std::string& path) {
    const auto response = client_.get(path);
    EXPECT_EQ(response.result_int(), 200U) << path << response.body();
    EXPECT_EQ(response[http::field::content_type], "application/json");
    return nlohmann::json::parse(response.body());
  }
  static std::string beside(const std::string& path, const nlohmann::json& uri) {
    return path.substr(0, path.rfind('/') + 1) + uri.get<std::string>();
  }

  RunningHttpServer server_{gyroid_catalogue()};
  HttpClient client_{server_.http()};
};

TEST_F(TilesetFiles, JoinLeavesToTheSurfaceWithoutACrack) {
  const std::string first = kFolder + "tileset.json";
  const auto json = tileset(first);
  std::vector<LatticeMesh> leaves;
  for (const auto& child : json["root"]["children"]) {
    const std::string path = beside(first, child["content"]["uri"]);
    const auto leaf = tileset(path)["root"];
    EXPECT_LT(leaf["geometricError"], json["root"]["geometricError"]);
    if (!leaf.contains("content")) continue;
    EXPECT_FALSE(leaf.contains("children"));
    const auto surface = client_.get(beside(path, leaf["content"]["uri"]));
    EXPECT_EQ(surface[http::field::content_type], "model/gltf-binary");
    leaves.push_back(testing::mesh_in(testing::read_glb(surface.body())));
    const std::vector<double> box = leaf["boundingVolume"]["box"];
    for (const LatticePoint& p : leaves.back().vertices) {
      const Vec3 at = grid_coordinates(p, kDefaultLatticeResolution);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        ASSERT_LE(std::abs(at[axis] - box[axis]), box[3 + 4 * axis]);
      }
    }
  }
  ASSERT_EQ(leaves.size(), 8U);
  const auto topology_of = [](std::vector<const LatticeMesh*> meshes) {
    return topology(weld(meshes, kDefaultLatticeResolution),
                    data_border(gyroid()->info, kDefaultLatticeResolution, 0));
  };
  std::vector<const LatticeMesh*> pointers;
  for (const LatticeMesh& leaf : leaves) pointers.push_back(&leaf);
  const MeshTopology found = topology_of(pointers);
  const TiledMesh full =
      SurfaceExtractor(gyroid()).extract({.request = {.isovalue = kIsovalue, .error = 0}});
  pointers.clear();
  for (const TileMesh& tile : full.tiles) pointers.push_back(&tile.mesh);
  const MeshTopology expected = topology_of(pointers);
  EXPECT_TRUE(found.is_sound());
  EXPECT_EQ(found.euler_characteristic, expected.euler_characteristic);
  EXPECT_EQ(found.components, expected.components);
  // Vertices on the cells' faces stay: a few triangles more than those of the whole surface.
  const TiledMesh whole = SurfaceExtractor(gyroid()).extract(
      {.request = {.isovalue = kIsovalue, .error = kDefaultError, .simplify = true}});
  std::size_t triangles = 0;
  for (const TileMesh& tile : whole.tiles) triangles += tile.mesh.triangles.size();
  EXPECT_LT(triangles, 0.5 * static_cast<double>(expected.triangles));
  EXPECT_LT(static_cast<double>(found.triangles), 1.3 * static_cast<double>(triangles));
}

TEST_F(TilesetFiles, HaveImmutableContents) {
  const std::string first = kFolder + "tileset.json";
  const auto response = client_.get(first);
  EXPECT_EQ(response[http::field::cache_control], "public, no-cache");
  const std::string path =
      beside(first, nlohmann::json::parse(response.body())["root"]["content"]["uri"]);
  const auto surface = client_.get(path);
  EXPECT_EQ(surface[http::field::cache_control], "public, max-age=31536000, immutable");
  const std::string tag(surface[http::field::etag]);
  EXPECT_EQ(client_.get(path, "If-None-Match: " + tag + "\r\n").result_int(), 304U);
  EXPECT_EQ(client_.get(path).body(), surface.body());
  RunningHttpServer other{gyroid_catalogue()};
  EXPECT_EQ(HttpClient(other.http()).get(path).body(), surface.body());
}

TEST_F(TilesetFiles, RejectUnknownFilesWithAReason) {
  const std::string id = tileset(kFolder + "tileset.json")["asset"]["tilesetVersion"];
  const std::map<std::string, std::pair<unsigned, std::string>> answers = {
      {"/v1/3dtiles", {400, "invalid_argument"}},
      {"/v1/3dtiles/gyroid/tileset.json", {400, "invalid_argument"}},
      {"/v1/3dtiles/gyroid/iso/x/tileset.json", {400, "invalid_argument"}},
      {"/v1/3dtiles/gyroid/iso/1,error=-1/tileset.json", {400, "invalid_argument"}},
      {"/v1/3dtiles/nothing/iso/1/tileset.json", {404, "unknown_dataset"}},
      {kFolder + "0123456789abcdef/7-0-0-0.glb", {404, "unknown_dataset"}},
      {kFolder + id + "/7-0-0-0.png", {404, "unknown_dataset"}},
      {kFolder + id + "/7-0-0-1.glb", {404, "unknown_dataset"}},
      {kFolder + id + "/5-0-0-0.glb", {404, "unknown_dataset"}},
      {kFolder + id + "/../7-0-0-0.glb", {400, "invalid_argument"}}};
  for (const auto& [path, expected] : answers) {
    const auto response = client_.get(path);
    EXPECT_EQ(response.result_int(), expected.first) << path << response.body();
    EXPECT_EQ(error_code_of(response), expected.second) << path;
  }
  // An empty surface is a valid answer, not an error.
  const auto nothing = tileset("/v1/3dtiles/gyroid/iso/1e9/tileset.json")["root"];
  EXPECT_FALSE(nothing.contains("content"));
  EXPECT_FALSE(nothing.contains("children"));
}

class NeuroglancerFiles : public TilesetFiles {
 protected:
  static std::string at(const std::string& path) { return "/v1/neuroglancer/gyroid/" + path; }

  // Retries, like neuroglancer, while the server makes the file.
  auto answer(const std::string& path) {
    for (int attempt = 1;; ++attempt) {
      auto response = client_.get(path);
      if (response.result_int() != 503U || attempt == 100) return response;
      std::this_thread::sleep_for(std::chrono::seconds(1));
    }
  }
};

TEST_F(NeuroglancerFiles, NameExistingFragmentsInManifests) {
  const std::string segment = std::to_string(segment_of(kIsovalue));
  const auto index = answer(at("surfaces,error=1/" + segment + ".index"));
  ASSERT_EQ(index.result_int(), 200U) << index.body();
  const auto u32 = [&](std::size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, index.body().data() + at, 4);
    return value;
  };
  // A grid of 2^7 steps: eight leaves and their root.
  ASSERT_EQ(u32(24), 2U);
  EXPECT_EQ(u32(28 + 4 * 2 + 12 * 2), 8U);
  EXPECT_EQ(u32(28 + 4 * 2 + 12 * 2 + 4), 1U);
  const auto data = client_.get(at("surfaces,error=1/" + segment), "Range: bytes=0-4\r\n");
  EXPECT_EQ(data.result_int(), 206U);
  EXPECT_EQ(data.body(), "DRACO");
  std::uint64_t sum = 0;
  const std::size_t sizes = 28 + 4 * 2 + 12 * 2 + 4 * 2;
  for (std::size_t i = 0; i < 8; ++i) sum += u32(sizes + 4 * (3 * 8 + i));
  sum += u32(sizes + 4 * (4 * 8 + 3));
  EXPECT_EQ(client_.get(at("surfaces,error=1/" + segment)).body().size(), sum);
  EXPECT_EQ(sizes + 4 * (4 * 8 + 4), index.body().size());
}

TEST_F(NeuroglancerFiles, ContainTheSamplesAsAnImage) {
  const auto info = tileset(at("image/info"));
  EXPECT_EQ(info["data_type"], "float32");
  const auto chunk = client_.get(at("image/1_1_1/64-90_0-64_16-32"));
  ASSERT_EQ(chunk.result_int(), 200U) << chunk.body();
  ASSERT_EQ(chunk.body().size(), 4U * 26 * 64 * 16);
  const Volume volume = testing::fields::gyroid(90, 0.1, 8);
  const auto& samples = std::get<std::vector<float>>(volume.samples);
  std::size_t at_byte = 0;
  for (int z = 16; z < 32; ++z) {
    for (int y = 0; y < 64; ++y) {
      for (int x = 64; x < 90; ++x, at_byte += 4) {
        float value = 0;
        std::memcpy(&value, chunk.body().data() + at_byte, 4);
        ASSERT_EQ(value, samples[volume.index(x, y, z)]);
      }
    }
  }
}

// A dataset whose steps are counted.
class CountedCells : public SurfaceProvider {
 public:
  [[nodiscard]] const DatasetInfo& info() const override { return steps_.info(); }
  [[nodiscard]] EncodedStep make(const StepRequest& step, std::stop_token stop) const override {
    ++made;
    return steps_.make(step, std::move(stop));
  }
  [[nodiscard]] SizeEstimates sizes(std::stop_token stop, SizeAccuracy accuracy) const override {
    return steps_.sizes(std::move(stop), accuracy);
  }
  mutable std::atomic<int> made = 0;

 private:
  CachingSurfaceProvider steps_{std::make_shared<const SurfaceExtractor>(gyroid())};
};

TEST_F(NeuroglancerFiles, Return304ForMatchingTags) {
  const auto steps = std::make_shared<CountedCells>();
  RunningHttpServer other(testing::catalogue_of(steps));
  const std::string segment = std::to_string(segment_of(kIsovalue));
  for (const std::string& path :
       {at("surfaces,error=1/" + segment + ".index"), at("surfaces,error=1/" + segment),
        at("image/1_1_1/64-90_0-64_16-32")}) {
    const std::string tag(answer(path)[http::field::etag]);
    EXPECT_NE(tag, "") << path;
    HttpClient client(other.http());
    const auto had = client.get(path, "If-None-Match: " + tag + "\r\n");
    EXPECT_EQ(had.result_int(), 304U) << path;
    EXPECT_EQ(had[http::field::etag], tag) << path;
  }
  EXPECT_EQ(steps->made, 0);
  const std::string index = segment + ".index";
  const auto fine = answer(at("surfaces,error=1/" + index));
  HttpClient client(other.http());
  const auto coarse = client.get(at("surfaces,error=2/" + index),
                                 "If-None-Match: " + std::string(fine[http::field::etag]) + "\r\n");
  EXPECT_NE(coarse.result_int(), 304U) << "another error is another file";
  EXPECT_GT(steps->made, 0);
}

TEST_F(NeuroglancerFiles, RejectUnknownFilesWithAReason) {
  const std::map<std::string, std::pair<unsigned, std::string>> answers = {
      {"/v1/neuroglancer/gyroid/info", {400, "invalid_argument"}},
      {at("surfaces,error=x/info"), {400, "invalid_argument"}},
      {at("surfaces,error=-1/info"), {400, "invalid_argument"}},
      {"/v1/neuroglancer/nothing/surfaces/info", {404, "unknown_dataset"}},
      {at("surfaces/x.index"), {404, "unknown_dataset"}},
      {at("image/1_1_1/0-65_0-64_0-16"), {404, "unknown_dataset"}},
      {at("surfaces/" + std::to_string(segment_of(1e9)) + ".index"), {404, "unknown_dataset"}}};
  for (const auto& [path, expected] : answers) {
    const auto response = client_.get(path);
    EXPECT_EQ(response.result_int(), expected.first) << path << response.body();
    EXPECT_EQ(error_code_of(response), expected.second) << path;
  }
}

TEST(GuardedTilesetFiles, AcceptATokenInTheHeaderOrThePath) {
  const TemporaryFolder folder;
  const testing::TokensFile tokens(folder.path(), {{"reader", "secret", "gyroid"}});
  RunningHttpServer server(gyroid_catalogue(), {}, {.admission = {.tokens = tokens.path()}});
  HttpClient client(server.http());
  const std::string path = "/3dtiles/gyroid/iso/0.1/tileset.json";
  EXPECT_EQ(client.get("/v1" + path).result_int(), 401U);
  EXPECT_EQ(client.get("/v1/token/wrong" + path).result_int(), 401U);
  const auto by_field = client.get("/v1" + path, "Authorization: Bearer secret\r\n");
  const auto by_path = client.get("/v1/token/secret" + path);
  EXPECT_EQ(by_path.result_int(), 200U);
  EXPECT_EQ(by_path.body(), by_field.body());
  EXPECT_EQ(by_path[http::field::cache_control], "private, no-cache");
}

TEST(CrawledTilesetFiles, AreRateLimitedLikeOtherRequests) {
  RunningHttpServer server(gyroid_catalogue(), {},
                           {.admission = {.requests = {.per_second = 0.001, .burst = 4}}});
  HttpClient client(server.http());
  for (const char* isovalue : {"0.1", "0.2", "0.3", "0.1"}) {
    EXPECT_EQ(client.get("/v1/3dtiles/gyroid/iso/" + std::string(isovalue) + "/tileset.json")
                  .result_int(),
              200U)
        << isovalue;
  }
  for (const std::string& file :
       {kFolder + "tileset.json", std::string("/v1/neuroglancer/gyroid/surfaces/info"),
        std::string("/v1/neuroglancer/gyroid/image/info")}) {
    const auto refused = client.get(file);
    EXPECT_EQ(refused.result_int(), 429U) << file;
    EXPECT_NE(refused[http::field::retry_after], "") << file;
  }
}

TEST(TokenRemoval, RemovesTokensFromTargets) {
  EXPECT_EQ(without_token("/v1/token/secret/3dtiles/a"), "/v1/token/.../3dtiles/a");
  EXPECT_EQ(without_token("/base/v1/token/secret"), "/base/v1/token/...");
  EXPECT_EQ(without_token("/v1/token/secret?x=1"), "/v1/token/...?x=1");
  EXPECT_EQ(without_token("/v1/datasets"), "/v1/datasets");
}

}  // namespace
}  // namespace multitetra
