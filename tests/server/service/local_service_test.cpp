// The service of one process without a transport: the test takes the place of a route.
#include "server/service/local_service.hpp"

#include <chrono>
#include <future>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/use_future.hpp>

#include "server/operations/log.hpp"
#include "tests/support/fake_steps.hpp"

namespace multitetra {
namespace {

using namespace std::chrono_literals;
using testing::catalogue_of;
using testing::Count;
using testing::FakeSteps;
using testing::MakeStep;

// A service with one dataset, and an admitted client.
struct Running {
  explicit Running(MakeStep make, LocalServiceOptions options = {.workers = 1},
                   AdmissionOptions admission_options = {})
      : admission(std::move(admission_options)),
        service(io.get_executor(), catalogue_of(std::make_shared<FakeSteps>("fake", make)),
                std::move(options)) {
    set_log_level(LogLevel::kOff);
  }
  ~Running() {
    if (service_client) service_client->close();
    io.restart();
    io.run();
    service.workers().join();
  }
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;

  template <typename T>
  std::future<T> start(asio::awaitable<T> coroutine) {
    auto result = asio::co_spawn(io, std::move(coroutine), asio::use_future);
    io.restart();
    io.poll();
    return result;
  }
  template <typename T>
  T finish(std::future<T> result) {
    io.restart();
    while (result.wait_for(0s) != std::future_status::ready) io.run_one_for(10ms);
    return result.get();
  }
  Result<void> log_in(const std::string& token = {}) {
    service_client = service.open(client);
    return finish(start(service_client->log_in(token)));
  }
  using Surfaces = std::vector<Surface>;
  std::future<Result<Surfaces>> request(SurfacesRequest request = {.dataset = "fake",
                                                                   .requests = {{.isovalue = 1}}}) {
    std::function<Result<Surfaces>(Surfaces, const std::stop_token&)> keep =
        [this](Surfaces surfaces, const std::stop_token&) {
          used_by = std::this_thread::get_id();
          return surfaces;
        };
    return start(
        service_client->made_from_surfaces<Surfaces>(std::move(request), "test", std::move(keep)));
  }

  AdmissionControl admission;
  asio::io_context io{1};
  LocalService service;
  ConnectionContextPtr client = admission.admit("http", "127.0.0.1", "test").client;
  ServiceClientPtr service_client;
  std::thread::id used_by;
};

EncodedStep octahedra(const StepRequest& step, const std::stop_token&) {
  return testing::octahedron_step(step);
}

TEST(LocalService, MakesFinalSurfacesAsOneMesh) {
  Running running(octahedra);
  ASSERT_TRUE(running.log_in());
  const auto surfaces = running.finish(running.request());
  ASSERT_TRUE(surfaces) << surfaces.error().text;
  ASSERT_EQ(surfaces->size(), 1U);
  const Surface& surface = surfaces->front();
  std::uint64_t triangles = 0;
  ContentDigest digest;
  for (const EncodedTile& tile : testing::fine_tiles()) {
    triangles += tile.summary.triangles;
    digest += tile.summary.digest;
  }
  EXPECT_EQ(surface.mesh.triangles.size(), triangles);
  EXPECT_EQ(surface.digest, digest);
}

TEST(LocalService, MakesWhatIsWantedOfAllSurfacesOnAWorker) {
  Running running(octahedra);
  ASSERT_TRUE(running.log_in());
  const auto surfaces = running.finish(
      running.request({.dataset = "fake", .requests = {{.isovalue = 1}, {.isovalue = 2}}}));
  ASSERT_TRUE(surfaces) << surfaces.error().text;
  ASSERT_EQ(surfaces->size(), 2U);
  EXPECT_EQ(surfaces->at(1).request.isovalue, 2);
  EXPECT_NE(running.used_by, std::this_thread::get_id());
  EXPECT_EQ(running.admission.queue().used(), 0U) << "of the first one while the second was made";
}

TEST(LocalService, ReturnsNothingBeforeATokenIsChecked) {
  Running running(octahedra);
  running.service_client = running.service.open(running.client);
  EXPECT_EQ(running.finish(running.request()).error().code, ErrorCode::kUnknownDataset);
}

TEST(LocalService, RejectsASurfaceOfTooManyTriangles) {
  Running running(octahedra);
  ASSERT_TRUE(running.log_in());
  const auto refused = running.finish(
      running.request({.dataset = "fake", .requests = {{.isovalue = 1}}, .max_triangles = 3}));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kLimitExceeded);
  EXPECT_EQ(running.admission.queue().used(), 0U);
}

TEST(LocalService, ReservesMemoryForWaitingRequestsAndTheMesh) {
  Running small(octahedra, {.workers = 1}, {.queue_bytes = 1000});
  ASSERT_TRUE(small.log_in());
  EXPECT_EQ(small.finish(small.request()).error().code, ErrorCode::kUnavailable);
}

TEST(LocalService, ReservesMemoryForMeshesInUse) {
  Running small(octahedra, {.workers = 1}, {.queue_bytes = 4 * 4200});
  ASSERT_TRUE(small.log_in());
  const auto refused = small.finish(small.request());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUnavailable);
  EXPECT_GT(refused.error().retry_after, 0);
}

TEST(LocalService, UsesNoWorkerForAClosedCaller) {
  Count working;
  Running running(testing::endless(working));
  ASSERT_TRUE(running.log_in());
  auto surface = running.request();
  ASSERT_TRUE(working.reaches(1));
  running.service_client->close(Error{ErrorCode::kUnavailable, "The server stops."});
  const auto refused = running.finish(std::move(surface));
  EXPECT_EQ(refused.error().code, ErrorCode::kUnavailable) << "why it was closed";
  EXPECT_TRUE(working.reaches(0));
}

TEST(LocalService, LimitsTheTimeForARequest) {
  Count working;
  Running running(testing::endless(working), {.workers = 1, .limits = {.request_time = 20ms}});
  ASSERT_TRUE(running.log_in());
  auto surface = running.request();
  ASSERT_TRUE(working.reaches(1));
  running.io.restart();
  running.io.poll();
  running.service_client->enforce_limits(std::chrono::steady_clock::now() + 1h);
  const auto refused = running.finish(std::move(surface));
  EXPECT_EQ(refused.error().code, ErrorCode::kLimitExceeded);
}

TEST(LocalService, DescribesDatasetsButStartsNothingWhileDraining) {
  Running running(octahedra);
  running.admission.drain([] {});
  ASSERT_TRUE(running.log_in());
  EXPECT_TRUE(running.service_client->client_access().describe("fake"));
  EXPECT_EQ(running.finish(running.request()).error().code, ErrorCode::kUnavailable);
}

TEST(LocalService, ChecksRequestsAsForConversations) {
  Running running(octahedra, {.workers = 1, .requests = {.max_regions = 0}});
  ASSERT_TRUE(running.log_in());
  SurfacesRequest request{.dataset = "fake", .requests = {{.isovalue = 1, .error = -1}}};
  EXPECT_EQ(running.finish(running.request(request)).error().code, ErrorCode::kInvalidArgument);
  request.requests[0].error = 1;
  request.requests[0].thresholds.regions.resize(1);
  EXPECT_FALSE(running.finish(running.request(request)));
}

TEST(LocalService, UsesTheCatalogueOfTheTokenCheck) {
  Running running(octahedra);
  ASSERT_TRUE(running.log_in());
  running.service.offer(testing::fake_catalogue("another"));
  EXPECT_TRUE(running.service_client->client_access().describe("fake"))
      << "as long as the request lasts";
  ASSERT_TRUE(running.log_in());
  EXPECT_FALSE(running.service_client->client_access().describe("fake"));
  EXPECT_TRUE(running.service_client->client_access().describe("another"));
}

}  // namespace
}  // namespace multitetra
