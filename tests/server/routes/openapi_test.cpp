// The served API description matches the server: the test provokes every path and status in it, no
// others occur, and bodies match their schemas.
#include <map>
#include <set>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "common/json/json_report.hpp"
#include "server/tilesets/neuroglancer.hpp"
#include "tests/support/fake_steps.hpp"
#include "tests/support/fields.hpp"
#include "tests/support/make_dataset.hpp"
#include "tests/support/running_http_server.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

using testing::catalogue_of;
using testing::FakeSteps;
using testing::HttpClient;
using testing::kUpgradeFields;
using testing::RunningHttpServer;

// The subset of JSON Schema that the description uses.
class Schemas {
 public:
  explicit Schemas(const Json& document) : document_(document) {}

  [[nodiscard]] const Json& resolved(const Json& node) const {
    if (!node.contains("$ref")) return node;
    return document_.at(Json::json_pointer(node.at("$ref").get<std::string>().substr(1)));
  }
  void expect(const Json& value, const Json& reference, const std::string& where) const {
    const Json& schema = resolved(reference);
    if (schema.contains("type")) {
      EXPECT_TRUE(is_of(value, schema.at("type"))) << where << ": " << value;
    }
    if (schema.contains("enum")) {
      const auto& words = schema.at("enum");
      EXPECT_NE(std::find(words.begin(), words.end(), value), words.end()) << where;
    }
    if (value.is_object()) {
      for (const auto& name : schema.value("required", Json::array())) {
        EXPECT_TRUE(value.contains(name.get<std::string>())) << where << " has no " << name;
      }
    }
    if (value.is_object() && schema.contains("properties")) {
      for (const auto& [name, part] : value.items()) {
        const bool is_known = schema.at("properties").contains(name);
        EXPECT_TRUE(is_known) << where << " has " << name;
        if (is_known) expect(part, schema.at("properties").at(name), where + "." + name);
      }
    }
    if (value.is_array() && schema.contains("items")) {
      EXPECT_GE(value.size(), schema.value("minItems", std::size_t{0})) << where;
      EXPECT_LE(value.size(), schema.value("maxItems", value.size())) << where;
      for (const auto& item : value) expect(item, schema.at("items"), where + "[]");
    }
  }

 private:
  static bool is_of(const Json& value, const Json& type) {
    if (type.is_array()) {
      return std::any_of(type.begin(), type.end(), [&](const Json& t) { return is_of(value, t); });
    }
    if (type == "object") return value.is_object();
    if (type == "array") return value.is_array();
    if (type == "string") return value.is_string();
    if (type == "integer") return value.is_number_integer();
    if (type == "number") return value.is_number();
    if (type == "boolean") return value.is_boolean();
    return type == "null" && value.is_null();
  }
  const Json& document_;
};

class TellingSteps : public FakeSteps {
 public:
  TellingSteps(std::string name, testing::MakeStep make)
      : FakeSteps(std::move(name), std::move(make)), info_(FakeSteps::info()) {
    info_.content_id = 1;
  }
  [[nodiscard]] const DatasetInfo& info() const override { return info_; }

 private:
  DatasetInfo info_;
};

// A dataset with samples: noise.
class SampledSteps : public FakeSteps {
 public:
  explicit SampledSteps(std::string name)
      : FakeSteps(name), dataset_(make_dataset(testing::fields::noise({17, 17, 17}, 1), name)) {
    info_ = dataset_->info;
    info_.content_id = 2;
  }
  [[nodiscard]] const DatasetInfo& info() const override { return info_; }
  [[nodiscard]] const PreparedVolume* volume() const override { return dataset_.get(); }

 private:
  DatasetPtr dataset_;
  DatasetInfo info_;
};

// The step with normals, if the request has them.
EncodedStep shaded(EncodedStep step, const IsosurfaceRequest& request) {
  if (request.normal_bits == 0) return step;
  for (EncodedTile& tile : step.tiles) {
    const auto mesh = decode_tile(*tile.payload, tile.summary, request.lattice_resolution);
    const std::vector<UnitVector> up(mesh.value().vertices.size(), UnitVector{0, 0, 1});
    tile = encode_tile(*mesh, tile.summary.cube, kDefaultEncodingSpeed,
                       {.directions = up, .bits = request.normal_bits});
  }
  return step;
}

class OpenApiTest : public ::testing::Test {
 protected:
  OpenApiTest() {
    const auto make = [](const StepRequest& step, const std::stop_token&) -> EncodedStep {
      if (step.request.isovalue == 13) throw std::runtime_error("failure");
      if (step.request.isovalue == 12) return {};
      return shaded(testing::octahedron_step(step), step.request);
    };
    const auto catalogue = catalogue_of(std::make_shared<TellingSteps>("a b", make));
    catalogue->add(std::make_shared<SampledSteps>("noise"));
    const auto tile = testing::fine_tiles().front();
    tile_path_ = "/v1/tiles/" + tile.summary.digest.hex();
    server_ = std::make_unique<RunningHttpServer>(
        catalogue, HttpOptions{},
        ServerOptions{.admission = {.tokens = tokens_.path()},
                      .service = {.cache = testing::cache_of(tile, "a b")},
                      .metrics = std::make_shared<PrometheusMetrics>()},
        RouteOptions{.max_mesh_triangles = 17}, [this] { return is_ready_.load(); });
    bare_ = std::make_unique<RunningHttpServer>(catalogue);
    HttpClient client(server_->http());
    document_ = Json::parse(client.get("/v1/openapi.json").body());
  }

  // Sends a request and expects the status to be in the description of `path`.
  void request(const std::string& path, const std::string& target, unsigned status,
               const std::string& fields = {}, bool at_bare_server = false) {
    HttpClient client((at_bare_server ? bare_ : server_)->http());
    const auto response = client.get(target, fields);
    ASSERT_EQ(response.result_int(), status) << target << ": " << response.body();
    const Schemas schemas(document_);
    const Json& responses = document_.at("paths").at(path).at("get").at("responses");
    const std::string word = std::to_string(status);
    ASSERT_TRUE(responses.contains(word)) << path << " " << word << " is not described";
    seen_.insert(path + " " + word);
    const Json& described = schemas.resolved(responses.at(word));
    const Json headers = described.value("headers", Json::object());
    for (const auto& [name, header] : headers.items()) {
      if (!header.value("required", true)) continue;
      EXPECT_EQ(response.count(name), 1U) << target << " has no " << name;
    }
    if (!described.contains("content")) return;
    std::string type(response[http::field::content_type]);
    type = type.substr(0, type.find(';'));
    ASSERT_TRUE(described.at("content").contains(type)) << target << " is " << type;
    if (type == "application/json") {
      schemas.expect(Json::parse(response.body()), described.at("content").at(type).at("schema"),
                     path);
    }
  }

  void expect_parameters_are_described(const std::string& what) {
    HttpClient client(server_->http());
    const auto refusal = client.get("/v1/datasets/noise/" + what + "?nonsense=1").body();
    std::set<std::string> known;
    const std::string text = Json::parse(refusal).at("error").at("text");
    std::string list = text.substr(text.rfind(": ") + 2);
    list.pop_back();
    for (std::size_t at = 0; at != std::string::npos;) {
      const std::size_t comma = list.find(", ", at);
      known.insert(list.substr(at, comma == std::string::npos ? comma : comma - at));
      at = comma == std::string::npos ? comma : comma + 2;
    }
    std::set<std::string> described;
    const Json& operation = document_.at("paths").at("/v1/datasets/{name}/" + what).at("get");
    const Schemas schemas(document_);
    for (const auto& one : operation.at("parameters")) {
      const Json& parameter = schemas.resolved(one);
      if (parameter.at("in") == "query") described.insert(parameter.at("name"));
    }
    EXPECT_EQ(described, known) << what;
  }

  // Clients without a token may access everything; unknown tokens are rejected.
  TemporaryFolder folder_;
  testing::TokensFile tokens_{folder_.path(),
                              {{"clients", "", "*"}, {"guest", "guest", "* only=surfaces"}}};
  std::atomic<bool> is_ready_ = true;
  std::string tile_path_;
  std::unique_ptr<RunningHttpServer> server_;
  std::unique_ptr<RunningHttpServer> bare_;
  Json document_;
  std::set<std::string> seen_;
};

constexpr const char* kBad = "Authorization: Bearer bad\r\n";
constexpr const char* kGuest = "Authorization: Bearer guest\r\n";  // May not see samples.
constexpr const char* kAny = "If-None-Match: *\r\n";

TEST_F(OpenApiTest, MatchesTheServer) {
  request("/livez", "/livez", 200);
  request("/readyz", "/readyz", 200);
  is_ready_ = false;
  request("/readyz", "/readyz", 503);
  request("/metrics", "/metrics", 200);
  request("/metrics", "/metrics", 404, "", /*at_bare_server=*/true);
  request("/v1/openapi.json", "/v1/openapi.json", 200);
  request("/v1/openapi.json", "/v1/openapi.json", 304, kAny);
  request("/v1/datasets", "/v1/datasets", 200);
  request("/v1/datasets", "/v1/datasets", 304, kAny);
  request("/v1/datasets/{name}", "/v1/datasets/a%20b", 200);
  request("/v1/datasets/{name}", "/v1/datasets/a%20b", 304, kAny);
  request("/v1/datasets/{name}", "/v1/datasets/none", 404);
  request("/v1/datasets", "/v1/datasets", 401, kBad);
  request("/v1/datasets/{name}", "/v1/datasets/a%20b", 401, kBad);

  const std::string tile = "/v1/tiles/{hash}";
  request(tile, tile_path_, 200);
  request(tile, tile_path_, 206, "Range: bytes=0-1\r\n");
  request(tile, tile_path_, 304, kAny);
  request(tile, "/v1/tiles/12", 400);
  request(tile, tile_path_, 401, kBad);
  request(tile, "/v1/tiles/" + ContentDigest{}.hex(), 404);
  request(tile, tile_path_, 416, "Range: bytes=9999999-\r\n");

  const std::string surface = "/v1/datasets/{name}/isosurface";
  const std::string at = "/v1/datasets/a%20b/isosurface?isovalue=";
  for (const auto* format : {"glb", "ply", "stl", "obj", "drc", "vtp", "3mf"}) {
    request(surface, at + "1&format=" + format, 200);
  }
  request(surface, at + "12&format=drc", 204);
  request(surface, at + "1", 206, "Range: bytes=0-1\r\n");
  request(surface, at + "1", 304, kAny);
  request(surface, at + "x", 400);
  request(surface, "/v1/datasets/none/isosurface", 404);
  request(surface, at + "1", 406, "Accept: text/html\r\n");
  request(surface, at + "1", 416, "Range: bytes=9999999-\r\n");
  request(surface, at + "13", 500);
  request(surface, at + "1", 401, kBad);

  const std::string slice = "/v1/datasets/{name}/slice";
  const std::string of_noise = "/v1/datasets/noise/slice";
  request(slice, of_noise, 200);
  request(slice, of_noise + "?format=raw&normal=1,1,0", 200);
  request(slice, of_noise, 206, "Range: bytes=0-1\r\n");
  request(slice, of_noise, 304, kAny);
  request(slice, of_noise + "?axis=w", 400);
  request(slice, of_noise, 401, kBad);
  request(slice, of_noise, 403, kGuest);
  request(surface, at + "0.1&error=0.5&color_by=noise", 403, kGuest);
  request(slice, of_noise + "?axis=w", 403, kGuest);
  request(slice, of_noise, 403, std::string(kGuest) + kAny);
  request(slice, "/v1/datasets/none/slice", 404);
  request(slice, of_noise, 416, "Range: bytes=9999999-\r\n");
  request(slice, of_noise + "?width=2000000", 422);
  request(slice, "/v1/datasets/a%20b/slice", 500);
  const std::string value = "/v1/datasets/{name}/probe";
  request(value, "/v1/datasets/noise/probe?at=1,2,3&at=-1,0,0", 200);
  request(value, "/v1/datasets/noise/probe?at=1,2", 400);
  request(value, "/v1/datasets/noise/probe?at=1,2,3", 401, kBad);
  request(value, "/v1/datasets/noise/probe?at=1,2,3", 403, kGuest);
  request(value, "/v1/datasets/noise/probe?at=1,2", 403, kGuest);
  request(value, "/v1/datasets/none/probe?at=1,2,3", 404);
  request(value, "/v1/datasets/a%20b/probe?at=1,2,3", 500);
  std::string many = "/v1/datasets/noise/probe?at=0,0,0";
  for (int i = 0; i < 1024; ++i) many += "&at=0,0,0";
  request(value, many, 422);

  const std::string thumbnail = "/v1/datasets/{name}/thumbnail.png";
  const std::string of_octahedron = "/v1/datasets/a%20b/thumbnail.png?isovalue=1";
  request(thumbnail, of_octahedron, 200);
  request(thumbnail, of_octahedron, 206, "Range: bytes=0-1\r\n");
  request(thumbnail, of_octahedron, 304, kAny);
  request(thumbnail, of_octahedron + "&up=w", 400);
  request(thumbnail, of_octahedron, 401, kBad);
  request(thumbnail, "/v1/datasets/none/thumbnail.png", 404);
  request(thumbnail, of_octahedron, 416, "Range: bytes=9999999-\r\n");
  request(thumbnail, "/v1/datasets/a%20b/thumbnail.png?isovalue=13", 500);

  const std::string tileset = "/v1/3dtiles/{name}/iso/{settings}/tileset.json";
  const std::string tree = "/v1/3dtiles/a%20b/iso/";
  request(tileset, tree + "1/tileset.json", 200);
  request(tileset, tree + "1/tileset.json", 304, kAny);
  request(tileset, tree + "x/tileset.json", 400);
  request(tileset, tree + "1/tileset.json", 401, kBad);
  request(tileset, "/v1/3dtiles/none/iso/1/tileset.json", 404);
  request(tileset, tree + "13/tileset.json", 500);
  const std::string cell = "/v1/3dtiles/{name}/iso/{settings}/{id}/{file}";
  const std::string uri =
      Json::parse(HttpClient(server_->http()).get(tree + "1/tileset.json").body())
          .at("root")
          .at("content")
          .at("uri");
  const std::string id = uri.substr(0, uri.find('/'));
  const std::string root = uri.substr(0, uri.rfind('.'));
  request(cell, tree + "1/" + root + ".json", 200);
  request(cell, tree + "1/" + uri, 200);
  request(cell, tree + "1/" + uri, 206, "Range: bytes=0-1\r\n");
  request(cell, tree + "1/" + uri, 304, kAny);
  request(cell, tree + "x/" + uri, 400);
  request(cell, tree + "1/" + uri, 401, kBad);
  request(cell, tree + "1/" + id + "/none.glb", 404);
  request(cell, tree + "1/" + uri, 416, "Range: bytes=9999999-\r\n");
  request(cell, tree + "13/" + uri, 500);

  const std::string mesh = "/v1/neuroglancer/{name}/{surfaces}/{path}";
  const std::string image = "/v1/neuroglancer/{name}/image/{path}";
  const auto index = [](double isovalue) {
    return "/v1/neuroglancer/a%20b/surfaces/" + std::to_string(segment_of(isovalue)) + ".index";
  };
  request(mesh, "/v1/neuroglancer/a%20b/surfaces/info", 200);
  request(mesh, index(1), 200);
  request(mesh, index(1), 206, "Range: bytes=0-1\r\n");
  request(mesh, index(1), 304, kAny);
  request(mesh, "/v1/neuroglancer/a%20b/surfaces,error=x/info", 400);
  request(mesh, index(1), 401, kBad);
  request(mesh, index(12), 404);
  request(mesh, index(1), 416, "Range: bytes=9999999-\r\n");
  request(mesh, index(13), 500);
  const std::string voxels = "/v1/neuroglancer/noise/image/1_1_1/0-17_0-17_0-16";
  request(image, "/v1/neuroglancer/noise/image/info", 200);
  request(image, voxels, 200);
  request(image, voxels, 206, "Range: bytes=0-1\r\n");
  request(image, voxels, 304, kAny);
  request(image, "/v1/neuroglancer/noise/image", 400);
  request(image, voxels, 401, kBad);
  request(image, voxels, 403, kGuest);
  request(image, voxels, 403, std::string(kGuest) + kAny);
  request(image, voxels + "x", 404);
  request(image, voxels, 416, "Range: bytes=9999999-\r\n");
  request(image, "/v1/neuroglancer/a%20b/image/1_1_1/0-64_0-64_0-16", 500);

  request("/v1/stream", "/v1/stream", 426);
  request("/v1/stream", "/v1/stream", 400, kUpgradeFields);
  const std::string good =
      std::string(kUpgradeFields) + "Sec-WebSocket-Protocol: multitetra.v1\r\n";
  request("/v1/stream", "/v1/stream", 403, good + "Origin: https://elsewhere\r\n");
  request("/v1/stream", "/v1/stream", 101, good);

  // Provoked in other tests: servers that stop, rate limits, meshes above the limit.
  const std::set<std::string> elsewhere = {"/v1/datasets 429",
                                           "/v1/datasets/{name} 429",
                                           surface + " 429",
                                           "/v1/datasets 503",
                                           "/v1/datasets/{name} 503",
                                           surface + " 422",
                                           surface + " 503",
                                           surface + " 507",
                                           slice + " 429",
                                           slice + " 503",
                                           value + " 429",
                                           value + " 503",
                                           thumbnail + " 429",
                                           thumbnail + " 503",
                                           tileset + " 422",
                                           tileset + " 429",
                                           tileset + " 503",
                                           cell + " 422",
                                           cell + " 429",
                                           cell + " 503",
                                           mesh + " 422",
                                           mesh + " 429",
                                           mesh + " 503",
                                           image + " 422",
                                           image + " 429",
                                           image + " 503"};
  for (const auto& [path, item] : document_.at("paths").items()) {
    for (const auto& [status, unused] : item.at("get").at("responses").items()) {
      const std::string one = path + " " + status;
      EXPECT_TRUE(seen_.contains(one) || elsewhere.contains(one)) << one << " was not provoked";
    }
  }
}

// The description names exactly the parameters that the server accepts.
TEST_F(OpenApiTest, ListsAllParameters) {
  for (const std::string what : {"isosurface", "slice", "probe", "thumbnail.png"}) {
    expect_parameters_are_described(what);
  }
}

}  // namespace
}  // namespace multitetra
