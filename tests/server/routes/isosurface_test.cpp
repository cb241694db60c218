// Isosurfaces as files over HTTP.
#include <sys/resource.h>

#include <atomic>
#include <chrono>
#include <csignal>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "common/json/json_report.hpp"
#include "server/http/detail/min_transfer_rate.hpp"
#include "server/routes/detail/mesh_file_cache.hpp"
#include "tests/support/fake_steps.hpp"
#include "tests/support/running_http_server.hpp"

namespace multitetra {
namespace {

using namespace std::chrono_literals;
using testing::catalogue_of;
using testing::error_code_of;
using testing::FakeSteps;
using testing::HttpClient;
using testing::RunningHttpServer;

// Octahedra with a given content id that count their extractions.
class CountedSteps : public FakeSteps {
 public:
  explicit CountedSteps(std::atomic<int>& made)
      : FakeSteps("octahedron",
                  [&made](const StepRequest& step, const std::stop_token&) {
                    ++made;
                    return testing::octahedron_step(step);
                  }),
        info_(FakeSteps::info()) {
    info_.content_id = 42;
    info_.suggested_isovalues = {0.5};
    info_.member = SeriesMember{.series = "organs", .label = Label{.value = 17, .name = "liver"}};
    info_.meaning = {.space = WorldSpace::kLps, .length_unit = "µm", .value_unit = ""};
  }
  [[nodiscard]] const DatasetInfo& info() const override { return info_; }

 private:
  DatasetInfo info_;
};

constexpr const char* kPath = "/v1/datasets/octahedron/isosurface?isovalue=0.5&format=ply";

class IsosurfaceTest : public ::testing::Test {
 protected:
  std::atomic<int> made_ = 0;
  RunningHttpServer server_{catalogue_of(std::make_shared<CountedSteps>(made_)),
                            {},
                            {},
                            {.max_mesh_triangles = 1000, .max_mesh_bytes_in_memory = 0}};
  HttpClient client_{server_.http()};
};

TEST_F(IsosurfaceTest, NamesUnitAndAxesOfItsWorld) {
  const std::string path = "/v1/datasets/octahedron/isosurface?isovalue=0.5";
  const auto world = client_.get(path);
  EXPECT_EQ(world["Multitetra-Length-Unit"], "%C2%B5m");
  EXPECT_EQ(world["Multitetra-Space"], "LPS");
  EXPECT_NE(world.body().find(R"("extras":{"length_unit":"µm","space":"LPS"})"), std::string::npos);
  const auto indices = client_.get(path + "&coordinates=index");
  EXPECT_EQ(indices.count("Multitetra-Length-Unit") + indices.count("Multitetra-Space"), 0U);
  EXPECT_EQ(indices.body().find("length_unit"), std::string::npos);
}

TEST_F(IsosurfaceTest, NamesItsLabel) {
  const std::string path = "/v1/datasets/octahedron/isosurface?isovalue=0.5&format=";
  EXPECT_NE(client_.get(path + "glb").body().find(R"("extras":{"label":17})"), std::string::npos);
  EXPECT_NE(client_.get(path + "glb").body().find(R"("name":"liver")"), std::string::npos);
  EXPECT_NE(client_.get(path + "ply").body().find("comment name liver\n"), std::string::npos);
  EXPECT_NE(client_.get(path + "obj").body().find(", label 17\no liver\n"), std::string::npos);
}

TEST_F(IsosurfaceTest, ReturnsAFileInEveryFormat) {
  for (const auto& [format, type, start] : {std::tuple{"ply", "application/ply", "ply\n"},
                                            {"glb", "model/gltf-binary", "glTF"},
                                            {"stl", "model/stl", ""},
                                            {"obj", "model/obj", ""},
                                            {"vtp", "application/vnd.vtk.polydata+xml", "<?xml"},
                                            {"3mf", "model/3mf", "PK"},
                                            {"drc", "application/vnd.draco", "DRACO"}}) {
    const auto response = client_.get("/v1/datasets/octahedron/isosurface?isovalue=0.5&format=" +
                                      std::string(format));
    EXPECT_EQ(response.result_int(), 200U) << response.body();
    EXPECT_EQ(response[http::field::content_type], type);
    EXPECT_TRUE(response.body().starts_with(start));
    EXPECT_EQ(response["Multitetra-Triangles"], "10");
    EXPECT_EQ(response["Multitetra-Euler-Characteristic"], "2");
  }
}

TEST_F(IsosurfaceTest, NamesTheLatticeInFiles) {
  EXPECT_NE(client_.get(std::string(kPath)).body().find("isosurface, lattice 5, label 17\n"),
            std::string::npos);
}

TEST_F(IsosurfaceTest, WarnsAboutUnlikelyRequests) {
  const std::string path = "/v1/datasets/octahedron/isosurface?format=ply";
  EXPECT_EQ(client_.get(path + "&isovalue=0.5").count("Multitetra-Notice"), 0U);
  const auto empty = client_.get(path + "&isovalue=1e9");
  EXPECT_EQ(empty.result_int(), 200U);
  EXPECT_NE(std::string(empty["Multitetra-Notice"]).find("no surface at isovalue 1e+09"),
            std::string::npos);
  const auto elsewhere = client_.get(path + "&isovalue=0.5&region=ball:900,0,0,1=0");
  EXPECT_TRUE(std::string(elsewhere["Multitetra-Notice"]).starts_with("Region 1 is outside"));
}

TEST_F(IsosurfaceTest, NegotiatesTheFormat) {
  const auto path = "/v1/datasets/octahedron/isosurface";
  const auto stl = client_.get(path, "Accept: model/stl\r\n");
  EXPECT_EQ(stl[http::field::content_type], "model/stl");
  EXPECT_EQ(stl[http::field::vary], "Accept");
  EXPECT_EQ(client_.get(path)[http::field::content_type], "model/gltf-binary");
  EXPECT_EQ(client_.get(path, "Accept: text/html\r\n").result_int(), 406U);
}

TEST_F(IsosurfaceTest, ExtractsOnceAndCaches) {
  const auto first = client_.get(kPath);
  const auto second = client_.get(kPath);
  EXPECT_EQ(first.body(), second.body());
  EXPECT_EQ(first[http::field::etag], second[http::field::etag]);
  EXPECT_EQ(made_, 1);
}

TEST_F(IsosurfaceTest, DoesNotExtractForHeadRequestsOrMatchingTags) {
  const auto head = client_.request("HEAD", kPath);
  EXPECT_EQ(head.result_int(), 200U);
  EXPECT_EQ(head.count(http::field::content_length), 0U);
  const std::string tag(head[http::field::etag]);
  const auto known = client_.get(kPath, "If-None-Match: " + tag + "\r\n");
  EXPECT_EQ(known.result_int(), 304U);
  EXPECT_EQ(made_, 0);
  const auto whole = client_.get(kPath);
  EXPECT_EQ(whole[http::field::etag], tag);
  const auto known_head = client_.request("HEAD", kPath);
  EXPECT_EQ(known_head[http::field::content_length], std::to_string(whole.body().size()));
}

TEST_F(IsosurfaceTest, SupportsRangeRequests) {
  const std::string whole = client_.get(kPath).body();
  const auto part = client_.get(kPath, "Range: bytes=10-\r\n");
  EXPECT_EQ(part.result_int(), 206U);
  EXPECT_EQ(part.body(), whole.substr(10));
  const auto changed = client_.get(kPath, "Range: bytes=10-\r\nIf-Range: \"other\"\r\n");
  EXPECT_EQ(changed.result_int(), 200U);
  EXPECT_EQ(changed.body(), whole);
  EXPECT_EQ(client_.get(kPath, "Range: bytes=99999-\r\n").result_int(), 416U);
}

TEST_F(IsosurfaceTest, ReturnsDifferentTagsForDifferentRequests) {
  const std::string path = kPath;
  const auto tag = [&](const std::string& more) {
    return std::string(client_.request("HEAD", path + more)[http::field::etag]);
  };
  EXPECT_EQ(tag("&error=1"), tag("&error=1.0"));  // The default.
  EXPECT_NE(tag(""), tag("&error=2"));
  EXPECT_NE(tag(""), tag("&region=ball:1,2,3,4=0.5"));
  EXPECT_NE(tag(""), tag("&coordinates=index"));
}

TEST_F(IsosurfaceTest, ReportsTheReasonForARejection) {
  const auto at = [&](const std::string& query) {
    return client_.get("/v1/datasets/octahedron/isosurface?" + query);
  };
  EXPECT_EQ(at("isovalue=x").result_int(), 400U);
  EXPECT_EQ(error_code_of(at("error=-1")), "invalid_argument");
  EXPECT_EQ(error_code_of(at("nonsense=1")), "invalid_argument");
  EXPECT_EQ(at("%zz").result_int(), 400U);
  EXPECT_EQ(client_.get("/v1/datasets/none/isosurface").result_int(), 404U);
}

TEST(Isosurface, RejectsSurfacesTooLargeForOneResponse) {
  std::atomic<int> made = 0;
  RunningHttpServer server(catalogue_of(std::make_shared<CountedSteps>(made)), {}, {},
                           {.max_mesh_triangles = 9});
  HttpClient client(server.http());
  const auto response = client.get(kPath);
  EXPECT_EQ(response.result_int(), 422U);
  EXPECT_EQ(error_code_of(response), "limit_exceeded");
}

TEST(Isosurface, StopsWhenTheClientHangsUp) {
  testing::Count running;
  RunningHttpServer server(
      catalogue_of(std::make_shared<FakeSteps>("octahedron", testing::endless(running))));
  {
    HttpClient client(server.http());
    client.send(std::string("GET ") + kPath + " HTTP/1.1\r\nHost: x\r\n\r\n");
    ASSERT_TRUE(running.reaches(1));
  }
  EXPECT_TRUE(running.reaches(0));
}

TEST(Isosurface, Returns503WhenTheServerStops) {
  testing::Count running;
  RunningHttpServer server(
      catalogue_of(std::make_shared<FakeSteps>("octahedron", testing::endless(running))));
  HttpClient client(server.http());
  client.send(std::string("GET ") + kPath + " HTTP/1.1\r\nHost: x\r\n\r\n");
  ASSERT_TRUE(running.reaches(1));
  std::thread stopping([&] { server.stop(); });
  EXPECT_EQ(client.receive().result_int(), 503U);
  EXPECT_EQ(client.rest(), "");
  stopping.join();
}

// ---- files on disk

StoredMesh stored(ByteReservations::Reservation reservation) {
  struct Holder {
    explicit Holder(ByteReservations::Reservation of_it) : reservation(std::move(of_it)) {}
    ByteReservations::Reservation reservation;
    ScratchFile file{std::filesystem::temp_directory_path()};
  };
  const std::uint64_t bytes = reservation.bytes();
  const auto held = std::make_shared<Holder>(std::move(reservation));
  return {.body = body_of(SharedFile(held, &held->file), bytes), .fields = ""};
}

TEST(MeshFileCache, EvictsCachedFilesForNewOnes) {
  MeshFileCache files(1000);
  files.keep("a", stored(files.reserve("one", 180).value()));
  files.keep("b", stored(files.reserve("another", 180).value()));
  EXPECT_TRUE(files.find("a"));
  EXPECT_TRUE(files.reserve("a third", 180));
  EXPECT_TRUE(files.find("a")) << "was requested last";
  EXPECT_FALSE(files.find("b"));
}

TEST(MeshFileCache, CountsFilesBeingSent) {
  MeshFileCache files(1000);
  std::vector<StoredMesh> sent;
  for (const auto& [share, bytes] : {std::pair("one", 250U), {"another", 187U}}) {
    sent.push_back(stored(files.reserve(share, bytes).value()));
    files.keep(share, sent.back());
  }
  const auto refused = files.reserve("a third", 141);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUnavailable);
  EXPECT_GT(refused.error().retry_after, 0);
  sent.pop_back();
  EXPECT_TRUE(files.reserve("a third", 187));
}

TEST(MeshFileCache, LimitsAShareToAQuarterOfTheRemainder) {
  MeshFileCache files(1000);
  const auto first = files.reserve("one", 150);
  EXPECT_FALSE(files.reserve("one", 150));
  EXPECT_TRUE(files.reserve("another", 212));
  EXPECT_FALSE(files.reserve("another", 213)) << "of the 850 bytes that are left";
  const auto never = files.reserve("one", 251);
  ASSERT_FALSE(never);
  EXPECT_EQ(never.error().code, ErrorCode::kLimitExceeded) << "It is no use to come again.";
}

TEST(MeshFileCache, KeepsSmallFilesInMemory) {
  MeshFileCache files(1000);
  files.keep("a", {.body = body_of(std::make_shared<const std::string>(100, 'x')), .fields = ""});
  EXPECT_TRUE(files.reserve("one", 250)) << "of a disk without files";
  EXPECT_EQ(files.find("a").value().body.length, 100U);
}

TEST(MeshFileCache, CachesAndRejectsNothingWithZeroCapacity) {
  MeshFileCache files(0);
  files.keep("a", stored(files.reserve("one", 400).value()));
  EXPECT_FALSE(files.find("a"));
}

TEST(MinTransferRate, LimitsTheTimeForEachPieceAndForAll) {
  using Clock = MinTransferRate::Clock;
  const Clock::time_point began{1000s};
  const MinTransferRate slowest(began, 60s, 1000);
  EXPECT_EQ(slowest.deadline(began, 1000), began + 60s);
  EXPECT_EQ(slowest.deadline(began + 59s, 10'000), began + 70s) << "at 1000 bytes a second";
  EXPECT_EQ(slowest.deadline(began + 5s, 1'000'000), began + 65s) << "this piece";
  EXPECT_EQ(MinTransferRate(began, 60s, 0).deadline(began + 1h, 10), began + 1h + 60s);
}

TEST_F(IsosurfaceTest, RejectsRequestsWithoutDiskSpace) {
  RunningHttpServer small(catalogue_of(std::make_shared<CountedSteps>(made_)), {}, {},
                          {.mesh_cache_bytes = 100, .max_mesh_bytes_in_memory = 0});
  HttpClient client(small.http());
  const auto refused = client.get(kPath);
  EXPECT_EQ(refused.result_int(), 422U);
  EXPECT_NE(refused.body().find("this server stores at most 25 in one file"), std::string::npos)
      << refused.body();
}

TEST_F(IsosurfaceTest, ReportsAnUnwritableTemporaryFolder) {
  RunningHttpServer full(
      catalogue_of(std::make_shared<CountedSteps>(made_)), {}, {},
      {.max_mesh_bytes_in_memory = 500, .temporary_folder = "/dev/null/nothing"});
  HttpClient client(full.http());
  EXPECT_EQ(client.get("/v1/datasets/octahedron/isosurface?isovalue=0.5&format=drc").result_int(),
            200U)
      << "in memory";
  const auto refused = client.get("/v1/datasets/octahedron/isosurface?isovalue=0.5&format=glb");
  EXPECT_EQ(refused.result_int(), 507U);
  EXPECT_NE(refused.body().find("temporary folder"), std::string::npos) << refused.body();
}

// The folder is full in the middle of a file.
TEST_F(IsosurfaceTest, ReportsAFullTemporaryFolder) {
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit tiny{.rlim_cur = 100, .rlim_max = before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &tiny), 0);
  const auto refused = client_.get(kPath);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(refused.result_int(), 507U) << refused.body();
  EXPECT_NE(refused.body().find("temporary folder"), std::string::npos) << refused.body();
  EXPECT_EQ(client_.get(kPath).result_int(), 200U);
}

}  // namespace
}  // namespace multitetra
