// Tilesets through a gateway: each file equals the server's file at the same path.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <chrono>
#include <thread>

#include "server/tilesets/neuroglancer.hpp"
#include "tests/server/gateway/running_gateway.hpp"
#include "tests/support/prepared_fields.hpp"
#include "tests/support/served_datasets.hpp"

namespace multitetra {
namespace {

using testing::HttpClient;
using testing::RunningGateway;
using testing::RunningHttpServer;
using testing::Upstream;

// A dataset with values scaled by `steepness`: same name, different content.
CataloguePtr gyroids(double steepness, std::uint64_t content_id) {
  Volume volume = testing::fields::gyroid(90, 0.1, 8);
  for (float& sample : std::get<std::vector<float>>(volume.samples))
    sample = static_cast<float>(sample * steepness);
  auto dataset = std::make_shared<PreparedVolume>(*testing::prepared({"gyroid", volume}));
  dataset->info.content_id = content_id;
  return testing::catalogue_with({dataset});
}

// Retries, like neuroglancer, while the server makes the file.
HttpClient::Response answer(HttpClient& client, const std::string& path) {
  for (int attempt = 1;; ++attempt) {
    auto response = client.get(path);
    if (response.result_int() != 503U || attempt == 100) return response;
    std::this_thread::sleep_for(std::chrono::seconds(1));
  }
}

// The paths of all files of a tree, given its first file.
std::vector<std::string> files_of_tree(const testing::HttpClient::Response& first,
                                       const std::string& folder) {
  const auto root = nlohmann::json::parse(first.body())["root"];
  std::vector<std::string> paths = {folder + root["content"]["uri"].get<std::string>()};
  for (const auto& child : root["children"])
    paths.push_back(folder + child["content"]["uri"].get<std::string>());
  return paths;
}

class ForwardedTilesets : public ::testing::Test {
 protected:
  const std::string folder_ = "/v1/3dtiles/gyroid/iso/0.1,error=1/";
  const CataloguePtr catalogue_ = gyroids(1, 7);
  RunningHttpServer server_{catalogue_};
  HttpClient direct_{server_.http()};
};

TEST_F(ForwardedTilesets, EqualTheFilesAndTagsOfAServer) {
  Upstream upstream(catalogue_);
  RunningGateway gateway({.upstream = {.upstreams = {upstream.endpoint()}}});
  HttpClient through(gateway.http());
  const std::string first = folder_ + "tileset.json";
  std::vector<std::string> paths = files_of_tree(direct_.get(first), folder_);
  ASSERT_EQ(paths.size(), 9U) << "a surface, and eight cells below";
  const std::string segment = std::to_string(segment_of(0.1));
  const std::string meshes = "/v1/neuroglancer/gyroid/surfaces,error=1/";
  const std::string image = "/v1/neuroglancer/gyroid/image/";
  paths.insert(paths.end(), {first, meshes + "info", meshes + "segment_properties/info",
                             meshes + segment + ".index", meshes + segment, image + "info",
                             image + "1_1_1/64-90_0-64_16-32"});
  for (const std::string& path : paths) {
    const auto expected = answer(direct_, path);
    const auto forwarded = answer(through, path);
    EXPECT_EQ(forwarded.result_int(), 200U) << path << forwarded.body();
    EXPECT_EQ(forwarded.body(), expected.body()) << path;
    for (const auto field : {http::field::etag, http::field::cache_control}) {
      EXPECT_EQ(forwarded[field], expected[field]) << path;
    }
    const std::string tag(forwarded[http::field::etag]);
    EXPECT_EQ(through.get(path, "If-None-Match: " + tag + "\r\n").result_int(), 304U) << path;
  }
}

TEST_F(ForwardedTilesets, ReturnTheServersErrors) {
  Upstream upstream(catalogue_);
  RunningGateway gateway({.upstream = {.upstreams = {upstream.endpoint()}}});
  HttpClient through(gateway.http());
  for (const std::string path :
       {"/v1/3dtiles/nothing/iso/1/tileset.json", "/v1/3dtiles/gyroid/iso/x/tileset.json",
        "/v1/3dtiles/gyroid/iso/0.1/0123456789abcdef/7-0-0-0.glb",
        "/v1/neuroglancer/gyroid/surfaces/x.index", "/v1/neuroglancer/nothing/image/info"}) {
    const auto expected = direct_.get(path);
    const auto forwarded = through.get(path);
    EXPECT_GE(forwarded.result_int(), 400U) << path;
    EXPECT_EQ(forwarded.result_int(), expected.result_int()) << path;
    EXPECT_EQ(testing::error_code_of(forwarded), testing::error_code_of(expected)) << path;
  }
}

TEST_F(ForwardedTilesets, ContinueAfterAServerIsLost) {
  auto first = std::make_unique<Upstream>(catalogue_);
  auto second = std::make_unique<Upstream>(catalogue_);
  RunningGateway gateway({.upstream = {.upstreams = {first->endpoint(), second->endpoint()}}});
  HttpClient through(gateway.http());
  const auto paths = files_of_tree(through.get(folder_ + "tileset.json"), folder_);
  for (std::size_t i = 0; i < paths.size(); ++i) {
    if (i == 3) first->stop();
    if (i == 6) {
      first->start_again();
      second->stop();
    }
    EXPECT_EQ(through.get(paths[i]).body(), direct_.get(paths[i]).body()) << paths[i];
  }
}

TEST_F(ForwardedTilesets, NeverMixDatasetsOfTheSameName) {
  Upstream old(catalogue_);
  Upstream other(gyroids(2, 8));
  RunningGateway gateway({.upstream = {.upstreams = {old.endpoint(), other.endpoint()}}});
  HttpClient through(gateway.http());
  const auto first = through.get(folder_ + "tileset.json");
  const auto paths = files_of_tree(first, folder_);
  const bool is_old = first.body() == direct_.get(folder_ + "tileset.json").body();
  EXPECT_EQ(through.get(paths[0]).result_int(), 200U);
  (is_old ? old : other).stop();
  EXPECT_TRUE(testing::eventually([&] { return through.get(paths[0]).result_int() == 404U; }));
  const auto paths_now = files_of_tree(through.get(folder_ + "tileset.json"), folder_);
  EXPECT_NE(paths_now[0], paths[0]);
  EXPECT_EQ(through.get(paths_now[0]).result_int(), 200U);
}

}  // namespace
}  // namespace multitetra
