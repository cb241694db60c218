// Real surfaces through the whole service: extracted, encoded, sent, decoded, checked.
#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>

#include "client/library/client.hpp"
#include "server/core/thresholds/threshold_map.hpp"
#include "server/dataset/prepare.hpp"
#include "server/dataset/prepared_format.hpp"
#include "server/dataset/section_table.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "server/service/caching_surface_provider.hpp"
#include "tests/support/distance_statistics.hpp"
#include "tests/support/fake_steps.hpp"
#include "tests/support/fields.hpp"
#include "tests/support/running_server.hpp"
#include "tests/support/served_datasets.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/volume_in_memory.hpp"

namespace multitetra {
namespace {

using testing::RunningServer;
namespace fields = testing::fields;
using testing::catalogue_with;
using testing::extracted_digest;

DatasetPtr noisy_gyroid_named(const std::string& name) {
  return make_dataset(fields::gyroid(76, 0.4, 7), name);
}
DatasetPtr noisy_gyroid() { return noisy_gyroid_named("gyroid"); }
DatasetPtr masked() { return make_dataset(fields::masked_gyroid(21, 3), "masked"); }
DatasetPtr closed_ball() {
  return make_dataset(fields::ball({20, 17, 23}, 9.5), "ball", /*outside=*/-100.0, /*margin=*/1);
}

CataloguePtr all_datasets() { return catalogue_with({noisy_gyroid(), masked(), closed_ball()}); }

Client client_of(const RunningServer& server) {
  // Requests Draco tiles: digests of sample shells are those of payloads, and shell_extractor_test
  // compares their surfaces.
  auto client = Client::connect(server.endpoint(), {.codecs = {PayloadCodec::kDracoLattice}});
  if (!client) throw std::runtime_error(client.error().error.text);
  return *std::move(client);
}

// Returns the steps of one stream, or none if it failed.
std::vector<FetchedStep> fetch(Client& client, const DatasetInfo& info,
                               const IsosurfaceRequest& request) {
  std::vector<FetchedStep> steps;
  const auto fetched =
      client.fetch(info, {.dataset = info.name, .request = request, .cached_tile_digests = {}},
                   [&steps](const FetchedStep& step) { steps.push_back(step); });
  EXPECT_TRUE(fetched) << fetched.error().error.text;
  return steps;
}

TEST(ServedSurfaces, MatchExtractionForAnyThreadCount) {
  const DatasetPtr dataset = noisy_gyroid();
  const IsosurfaceRequest request{.isovalue = 0.1, .error = 0.5};
  for (const std::size_t threads : {1U, 2U, 4U}) {
    SCOPED_TRACE(threads);
    const oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism,
                                            threads);
    RunningServer server(all_datasets(), {.service = {.workers = threads}});
    Client client = client_of(server);
    const auto steps = fetch(client, dataset->info, request);
    ASSERT_GE(steps.size(), 2U);
    for (const FetchedStep& fetched : steps) {
      const StepBegin& begin = fetched.step->begin;
      EXPECT_GT(fetched.step->topology.triangles, 0);
      EXPECT_EQ(fetched.step->end.digest,
                extracted_digest(dataset, {begin.request, begin.finest_spacing}));
    }
    EXPECT_EQ(steps.back().step->begin.request, request);
  }
}

TEST(ServedSurfaces, KeepTheTopologyInFewerBytesIfSimplified) {
  const DatasetPtr dataset = noisy_gyroid();
  const IsosurfaceRequest plain{.isovalue = 0.1, .error = 0.5};
  IsosurfaceRequest request = plain;
  request.simplify = true;
  RunningServer server(all_datasets());
  Client client = client_of(server);
  const auto expected = fetch(client, dataset->info, plain);
  ASSERT_FALSE(expected.empty());
  std::optional<std::vector<TileSummary>> first;
  for (const std::size_t threads : {1U, 4U}) {
    SCOPED_TRACE(threads);
    const oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism,
                                            threads);
    RunningServer again(all_datasets(), {.service = {.workers = threads}});
    Client other = client_of(again);
    const auto steps = fetch(other, dataset->info, request);
    ASSERT_FALSE(steps.empty());
    for (const FetchedStep& fetched : steps) {
      const StepBegin& begin = fetched.step->begin;
      StepRequest step = {begin.request, begin.finest_spacing};
      step.request.simplify = !begin.is_unsimplified;
      EXPECT_EQ(fetched.step->end.digest, extracted_digest(dataset, step));
    }
    const MeshTopology& full = expected.back().step->topology;
    const MeshTopology& small = steps.back().step->topology;
    EXPECT_EQ(small.euler_characteristic, full.euler_characteristic);
    EXPECT_EQ(small.components, full.components);
    EXPECT_LT(3 * small.triangles, full.triangles);
    EXPECT_LT(2 * steps.back().step->end.payload_bytes, expected.back().step->end.payload_bytes);
    EXPECT_EQ(steps.back().step->begin.error_bound_world, 0.5);
    const std::vector<TileSummary>& tiles = steps.back().step->begin.tiles;
    if (!first) first = tiles;
    EXPECT_EQ(tiles, *first) << "with bounds and bytes";
    for (const TileSummary& tile : tiles) {
      EXPECT_GT(tile.simplification_bound, 0);
      EXPECT_LT(tile.simplification_bound, 0.5);
    }
  }
}

std::vector<SurfaceTriangle> in_world(const FetchedStep& step, const DatasetInfo& info) {
  const PositionedMesh mesh = positioned(step.step->mesh, grid_to_world(info));
  const auto corner = [&](std::uint32_t v) { return mesh.positions[v]; };
  std::vector<SurfaceTriangle> surface;
  for (const auto& [a, b, c] : mesh.triangles) surface.push_back({corner(a), corner(b), corner(c)});
  return surface;
}

// Simplification takes each tile's least threshold into account: a ball is as exact as requested,
// and the rest is simplified strongly.
TEST(ServedSurfaces, StayWithinLocalThresholdsIfSimplified) {
  RunningServer server(all_datasets());
  Client client = client_of(server);
  const DatasetInfo info = noisy_gyroid()->info;
  const BallShape ball{.center = {20, 20, 20}, .radius = 16};
  IsosurfaceRequest request{.isovalue = 0.1, .error = 2};
  request.thresholds.regions = {{.shape = ball, .threshold = 0.2}};
  const auto full = fetch(client, info, {.isovalue = 0.1, .error = 0});
  const auto plain = fetch(client, info, request);
  request.simplify = true;
  const auto simplify = fetch(client, info, request);
  ASSERT_TRUE(!full.empty() && !plain.empty() && !simplify.empty());
  const MeshTopology& before = plain.back().step->topology;
  const MeshTopology& after = simplify.back().step->topology;
  EXPECT_EQ(after.euler_characteristic, before.euler_characteristic);
  EXPECT_EQ(after.components, before.components);
  EXPECT_LT(2 * after.triangles, before.triangles);

  // Nearest points may be across the ball's border.
  const double inside = ball.radius - 2;
  const double snapping = 2 * std::sqrt(3) / (2 << request.lattice_resolution);
  const auto limit = [&](const Vec3& p) {
    const bool is_inside =
        std::hypot(p[0] - ball.center[0], p[1] - ball.center[1], p[2] - ball.center[2]) < inside;
    return snapping + (is_inside ? 0.2 : 2.0);
  };
  const std::vector<SurfaceTriangle> exact = in_world(full.back(), info);
  const std::vector<SurfaceTriangle> given = in_world(simplify.back(), info);
  const auto there = distances(sampled_points(given, 40'000), NearestTriangle(exact), limit);
  const auto back = distances(sampled_points(exact, 40'000), NearestTriangle(given), limit);
  for (const DistanceStatistics& way : {there, back}) {
    EXPECT_EQ(way.above_limit, 0U) << way.worst_distance << " at (" << way.worst_place[0] << ", "
                                   << way.worst_place[1] << ", " << way.worst_place[2] << ")";
    EXPECT_GT(way.maximum, 0.5) << "outside of the ball";
  }
}

TEST(ServedSurfaces, AreTheSameSimplifiedOrNotAtErrorZero) {
  RunningServer server(all_datasets());
  Client client = client_of(server);
  const DatasetInfo info = closed_ball()->info;
  IsosurfaceRequest request{.isovalue = 0, .error = 0};
  const auto plain = fetch(client, info, request);
  request.simplify = true;
  const auto simplify = fetch(client, info, request);
  ASSERT_FALSE(plain.empty());
  ASSERT_FALSE(simplify.empty());
  EXPECT_EQ(simplify.back().step->end.digest, plain.back().step->end.digest);
}

TEST(ServedSurfaces, PassAllChecksOverFieldsIsovaluesAndErrors) {
  RunningServer server(all_datasets());
  Client client = client_of(server);
  const auto datasets = client.list_datasets();
  ASSERT_TRUE(datasets);
  ASSERT_EQ(datasets->size(), 3U);
  for (const DatasetInfo& info : *datasets) {
    for (const double part : {0.3, 0.5, 0.7}) {
      for (const double error : {0.0, 1.0, 4.0}) {
        SCOPED_TRACE(info.name + " at " + std::to_string(part) + ", error " +
                     std::to_string(error));
        const double isovalue = info.min + part * (info.max - info.min);
        for (const bool simplify : {false, true}) {
          EXPECT_FALSE(
              fetch(client, info, {.isovalue = isovalue, .error = error, .simplify = simplify})
                  .empty());
        }
      }
    }
  }
}

// Estimates and real sizes agree roughly.
TEST(ServedSurfaces, HaveSizesNearTheEstimates) {
  RunningServer server(all_datasets());
  Client client = client_of(server);
  const DatasetInfo info = noisy_gyroid()->info;
  for (const int normal_bits : {0, 8, 10}) {
    const IsosurfaceRequest request{
        .isovalue = 0.1, .error = 0.5, .simplify = normal_bits == 8, .normal_bits = normal_bits};
    const auto estimate = client.estimate(info.name, request);
    ASSERT_TRUE(estimate) << estimate.error().error.text;
    const auto steps = fetch(client, info, request);
    ASSERT_FALSE(steps.empty());
    double triangles = 0;
    double bytes = 0;
    for (const TileSummary& tile : steps.back().step->begin.tiles) {
      triangles += tile.triangles;
      bytes += tile.bytes;
    }
    EXPECT_NEAR(static_cast<double>(estimate->triangles), triangles, triangles / 3);
    EXPECT_NEAR(static_cast<double>(estimate->bytes), bytes, bytes / 3) << normal_bits << " bits";
    EXPECT_EQ(estimate->error_bound_world, 0.5);
  }
}

// The client checks the counts in the manifest against its budget.
TEST(ServedSurfaces, StayWithinTheirBudgetAndReportTheThreshold) {
  RunningServer server(all_datasets());
  Client client = client_of(server);
  const DatasetInfo info = noisy_gyroid()->info;
  const IsosurfaceRequest whole{.isovalue = 0.1, .error = 0.25};
  const auto triangles = [](const std::vector<FetchedStep>& steps) {
    return steps.back().step->topology.triangles;
  };
  const std::int64_t all = triangles(fetch(client, info, whole));
  // Smaller budgets cannot be met, as the topology of the noise needs this many triangles.
  const std::int64_t least =
      triangles(fetch(client, info, {.isovalue = whole.isovalue, .error = 1000}));
  for (const std::int64_t budget : {all / 2, (all + 3 * least) / 4, least}) {
    IsosurfaceRequest request = whole;
    request.max_triangles = static_cast<std::uint64_t>(budget);
    const auto steps = fetch(client, info, request);
    ASSERT_FALSE(steps.empty());
    EXPECT_LE(triangles(steps), budget);
    EXPECT_GE(10 * triangles(steps), 7 * budget) << "most of it";
    const IsosurfaceRequest& given = steps.back().step->begin.request;
    EXPECT_GT(given.thresholds.error_floor, whole.error);
    EXPECT_EQ(steps.back().step->begin.error_bound_world, given.thresholds.error_floor);
  }
  IsosurfaceRequest few_bytes = whole;
  few_bytes.max_bytes = 30'000;
  few_bytes.topology_tolerance = 2;
  const std::uint64_t bytes = fetch(client, info, few_bytes).back().step->end.payload_bytes;
  EXPECT_LE(bytes, 30'000U);
  EXPECT_GE(bytes, 21'000U);
}

// The error is reported for the request, not for a received surface.
TEST(ServedSurfaces, RejectATooSmallBudgetWithTheLeastPossible) {
  RunningServer server(all_datasets());
  Client client = client_of(server);
  const DatasetInfo info = noisy_gyroid()->info;
  const IsosurfaceRequest request{.isovalue = 0.1, .error = 0.25, .max_triangles = 1};
  const auto fetched =
      client.fetch(info, {.dataset = info.name, .request = request, .cached_tile_digests = {}},
                   [](const auto&) {});
  ASSERT_FALSE(fetched);
  EXPECT_EQ(fetched.error().source, ErrorSource::kServer);
  EXPECT_EQ(fetched.error().error.code, ErrorCode::kLimitExceeded);
  EXPECT_NE(fetched.error().error.text.find("budget of 1 triangles"), std::string::npos)
      << fetched.error().error.text;
  const auto estimate = client.estimate(info.name, request);
  ASSERT_FALSE(estimate);
  EXPECT_EQ(estimate.error().error.code, ErrorCode::kLimitExceeded);
  EXPECT_FALSE(fetch(client, info, {.isovalue = 0.1, .error = 4}).empty()) << "it goes on";
}

TEST(ServedSurfaces, HaveNormalsThatAgreeWithTheirTriangles) {
  RunningServer server(all_datasets());
  Client client = client_of(server);
  const DatasetInfo info = closed_ball()->info;
  for (const int bits : {8, 10}) {
    const auto steps = fetch(client, info, {.isovalue = 0.0, .error = 0.1, .normal_bits = bits});
    ASSERT_FALSE(steps.empty());
    const LatticeMesh& mesh = steps.back().step->mesh;
    ASSERT_EQ(mesh.normals.size(), mesh.vertices.size());
    const PositionedMesh in_world = positioned(mesh, grid_to_world(info));
    int opposed = 0;
    for (const TriangleIndices& t : in_world.triangles) {
      const auto& a = in_world.positions[t[0]];
      const auto& b = in_world.positions[t[1]];
      const auto& c = in_world.positions[t[2]];
      const Vec3 u = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
      const Vec3 v = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
      const Vec3 facet = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                          u[0] * v[1] - u[1] * v[0]};
      double along = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        along += facet[axis] * static_cast<double>(mesh.normals[t[0]][axis]);
      }
      opposed += along < 0 ? 1 : 0;
    }
    EXPECT_LE(opposed, static_cast<int>(in_world.triangles.size() / 100));
  }
}

// Users look at the regions with the smallest thresholds.
TEST(ServedSurfaces, SendTilesOfTheFinestRegionFirst) {
  const CachingSurfaceProvider source(std::make_shared<const SurfaceExtractor>(noisy_gyroid()));
  IsosurfaceRequest request{.isovalue = 0.1, .error = 4};
  request.thresholds.coordinates = CoordinateSystem::kIndex;
  request.thresholds.regions = {
      {.shape = BallShape{.center = {50, 50, 50}, .radius = 12}, .threshold = 0}};
  const EncodedStep step = source.make({.request = request}, {});
  ASSERT_GE(step.tiles.size(), 3U);
  const ThresholdMap thresholds(request, source.info());
  double before = 0;
  for (const EncodedTile& tile : step.tiles) {
    const OctreeCube& cube = tile.summary.cube;
    const double side = cube.side();
    const Vec3 low = {side * cube.x, side * cube.y, side * cube.z};
    const double least = thresholds.least_in({low, {low[0] + side, low[1] + side, low[2] + side}});
    EXPECT_GE(least, before);
    before = least;
  }
  EXPECT_LT(thresholds.least(), thresholds.largest());
}

TEST(ServedSurfaces, AreEmptyOutsideTheValueRange) {
  RunningServer server(all_datasets());
  Client client = client_of(server);
  const DatasetInfo info = noisy_gyroid()->info;
  const auto steps = fetch(client, info, {.isovalue = 1e6, .error = 1});
  ASSERT_FALSE(steps.empty());
  EXPECT_EQ(steps.back().step->topology.triangles, 0);
}

TEST(ServedSurfaces, SendNoTilesIfAllAreHeld) {
  RunningServer server(all_datasets());
  const DatasetInfo info = noisy_gyroid()->info;
  const OpenStream open{.dataset = "gyroid",
                        .request = {.isovalue = 0.1, .error = 0.5},
                        .steps = StepPolicy::kFinalOnly,
                        .cached_tile_digests = {}};
  MessageSocket socket = server.greet();
  const auto run = [&](std::uint64_t id, const CachedTiles& held) {
    OpenStream request = open;
    request.request_id = id;
    for (const auto& [digest, mesh] : held) request.cached_tile_digests.push_back(digest);
    EXPECT_TRUE(socket.send(request));
    Assembler assembler(info, request, held);
    for (;;) {
      const auto message = socket.receive();
      if (!message) throw std::runtime_error(message.error().text);
      const auto progress = assembler.receive(*message);
      if (!progress) throw std::runtime_error(progress.error().text);
      if (std::holds_alternative<StreamEnd>(*progress)) return assembler;
    }
  };
  const Assembler first = run(1, {});
  const Assembler second = run(2, first.held());
  EXPECT_GT(first.shown()->end.tiles_sent, 0U);
  EXPECT_EQ(second.shown()->end.tiles_sent, 0U);
  EXPECT_EQ(second.shown()->end.digest, first.shown()->end.digest);
}

TEST(ServedSurfaces, AreTheSameBytesForManyClients) {
  RunningServer server(all_datasets());
  const DatasetInfo info = noisy_gyroid()->info;
  const IsosurfaceRequest request{.isovalue = 0.2, .error = 1};
  std::vector<ContentDigest> digests(4);
  std::vector<std::thread> threads;
  for (ContentDigest& digest : digests) {
    threads.emplace_back([&server, &info, &request, &digest] {
      Client client = client_of(server);
      digest = fetch(client, info, request).back().step->end.digest;
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const ContentDigest& digest : digests) EXPECT_EQ(digest, digests.front());
}

// A file damaged after preparation: opening does not detect it, reading does.
TEST(ServedSurfaces, SendPreviewsOfSeveralDatasetsInOneStream) {
  auto catalogue = std::make_shared<DatasetCatalogue>();
  std::vector<std::string> names;
  for (int i = 0; i < 20; ++i) {  // More than a worker makes at a time.
    names.push_back("ball" + std::to_string(10 + i));
    const auto dataset = make_dataset(fields::ball({40, 40, 40}, 5.0 + 0.5 * i), names.back());
    catalogue->add(std::make_shared<CachingSurfaceProvider>(
        std::make_shared<const SurfaceExtractor>(dataset)));
  }
  RunningServer server(catalogue);
  auto connected = Client::connect(server.endpoint(), {});
  ASSERT_TRUE(connected);
  Client client = *std::move(connected);
  const auto previews = [&](const std::string& first, std::vector<std::string> further) {
    std::vector<ContentDigest> digests;
    const auto fetched =
        client.fetch(catalogue->find(first)->info(),
                     {.dataset = first,
                      .request = {.isovalue = 0},
                      .steps = StepPolicy::kPreviewsOnly,
                      .resumed_previews = {{.finest_spacing = 2, .shell = quantized_shells(2)}},
                      .further_datasets = std::move(further)},
                     [&](const FetchedStep& step) {
                       EXPECT_FALSE(step.step->begin.is_final);
                       EXPECT_EQ(step.step->begin.finest_spacing, 2);
                       EXPECT_EQ(step.step->topology.components, 1);
                       digests.push_back(step.step->end.digest);
                     });
    EXPECT_TRUE(fetched) << fetched.error().error.text;
    return digests;
  };
  const auto together = previews(names[0], {names.begin() + 1, names.end()});
  ASSERT_EQ(together.size(), names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    // A stream for one dataset goes on after that preview.
    EXPECT_EQ(previews(names[i], {}).front(), together[i]) << names[i];
  }
}

TEST(ServedSurfaces, FailOnlyRequestsOfADamagedBrick) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "gyroid.mtd";
  prepare(*source_of(fields::gyroid(40, 0.2, 7)), {.name = "gyroid"}, path, {});
  {
    std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
    const Section samples =
        *find_section(decode_section_table(FileSource(path)).value(), section_names::kSamples);
    file.seekp(static_cast<std::streamoff>(samples.offset + samples.size / 2));
    file.put('\x55');
  }
  RunningServer server(catalogue_with({open_dataset(path), noisy_gyroid_named("other")}));
  Client client = client_of(server);
  const DatasetPtr damaged = open_dataset(path);
  const auto fetched = client.fetch(
      damaged->info, {.dataset = "gyroid", .request = {.isovalue = 0.1}, .cached_tile_digests = {}},
      [](const FetchedStep&) {});
  ASSERT_FALSE(fetched);
  EXPECT_EQ(fetched.error().error.code, ErrorCode::kDamagedData);
  Client another = client_of(server);
  EXPECT_FALSE(fetch(another, noisy_gyroid_named("other")->info, {.isovalue = 0.1}).empty());
}

}  // namespace
}  // namespace multitetra
