// Simplification that stops at a budget: the surface is within it, uses most of it, has the
// topology of the full surface, and is as near to it as the returned threshold floor states.
#include "server/extraction/budgeted_surface.hpp"

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "common/mesh/mesh_checks.hpp"
#include "tests/support/distance_statistics.hpp"
#include "tests/support/lattice_intersections.hpp"
#include "tests/support/prepared_fields.hpp"
#include "tests/support/threshold_maps.hpp"
#include "tests/support/tiled_surfaces.hpp"

namespace multitetra::testing {
namespace {

double bytes_of(const TiledMesh& surface) {
  double sum = 0;
  for (const EncodedTile& tile : testing::encode_tiles(surface)) sum += tile.summary.bytes;
  return sum;
}

class BudgetedSurfaces : public ::testing::TestWithParam<PreparedSetting> {
 protected:
  static constexpr double kIsovalue = 0.1;

  [[nodiscard]] BudgetedSurface within(const IsosurfaceRequest& request) const {
    return surface_within_budget(extractor_, request, bytes_of, {});
  }
  [[nodiscard]] LatticeMesh whole(IsosurfaceRequest request) const {
    request.max_triangles = request.max_bytes = 0;
    return mesh_of(extractor_.extract({.request = request}));
  }
  // Checks all guarantees of a surface except its size.
  void expect_good(const BudgetedSurface& made, IsosurfaceRequest request) const {
    request.thresholds.error_floor = made.error_floor;
    const LatticeMesh full = whole({.isovalue = kIsovalue, .error = 0});
    const DataBorder border = data_border(info_, kDefaultLatticeResolution, 0);
    const MeshTopology expected = topology(full, border);
    const LatticeMesh small = mesh_of(made.surface);
    const MeshTopology found = topology(small, border);
    EXPECT_TRUE(found.is_sound());
    EXPECT_EQ(found.euler_characteristic, expected.euler_characteristic);
    EXPECT_EQ(found.components, expected.components);
    const double rounding = 2 * std::hypot(info_.spacing[0], info_.spacing[1], info_.spacing[2]) /
                            (1 << kDefaultLatticeResolution);
    const auto allowed = [&](const Vec3& place) {
      const Vec3 grid = {place[0] / info_.spacing[0], place[1] / info_.spacing[1],
                         place[2] / info_.spacing[2]};
      return threshold_at(request, info_, grid) + rounding;
    };
    const auto surface = placed(small, info_);
    const auto full_surface = placed(full, info_);
    const DistanceStatistics away =
        distances(sampled_points(surface, 6000), NearestTriangle(full_surface), allowed);
    const DistanceStatistics back =
        distances(sampled_points(full_surface, 6000), NearestTriangle(surface), allowed);
    EXPECT_EQ(away.above_limit, 0U) << away.worst_distance << " of " << away.worst_limit;
    EXPECT_EQ(back.above_limit, 0U) << back.worst_distance << " of " << back.worst_limit;
  }

  DatasetPtr dataset_ = prepared(GetParam());
  const DatasetInfo& info_ = dataset_->info;
  SurfaceExtractor extractor_{dataset_};
};

std::vector<PreparedSetting> some_fields() {
  return {{"noisy_gyroid", fields::gyroid(33, 0.3, 45)},
          {"stretched_gyroid", fields::gyroid(30, 0.1, 46, {1, 1, 2})},
          {"closed_noise", fields::noise({18, 16, 17}, 42), 0.0, 1},
          {"ball", fields::ball({40, 38, 44}, 15)}};
}
INSTANTIATE_TEST_SUITE_P(Fields, BudgetedSurfaces, ::testing::ValuesIn(some_fields()),
                         [](const auto& parameter) { return std::string(parameter.param.name); });

TEST_P(BudgetedSurfaces, UseNearlyAllAllowedTriangles) {
  for (const double error : {0.0, 0.2}) {
    const IsosurfaceRequest request{.isovalue = kIsovalue, .error = error, .simplify = true};
    const auto all = static_cast<double>(whole(request).triangles.size());
    IsosurfaceRequest coarse = request;
    coarse.error = 1e3;
    const auto least = static_cast<double>(whole(coarse).triangles.size());
    for (const double part : {0.6, 0.1}) {
      SCOPED_TRACE(::testing::Message() << error << " " << part);
      IsosurfaceRequest budgeted = request;
      budgeted.max_triangles = static_cast<std::uint64_t>(1.1 * least + part * (all - least));
      const BudgetedSurface made = within(budgeted);
      const auto triangles = static_cast<double>(mesh_of(made.surface).triangles.size());
      const auto most = static_cast<double>(budgeted.max_triangles);
      EXPECT_LE(triangles, most);
      EXPECT_GE(triangles, std::min(0.97 * most - 4, all));
      EXPECT_EQ(made.error_floor > error, most < all);
      expect_good(made, budgeted);
    }
  }
}

TEST_P(BudgetedSurfaces, UseNearlyAllAllowedBytes) {
  const IsosurfaceRequest request{.isovalue = kIsovalue, .error = 0.1, .simplify = true};
  const double all = bytes_of(extractor_.extract({.request = request}));
  IsosurfaceRequest coarse = request;
  coarse.error = 1e3;
  const double least = bytes_of(extractor_.extract({.request = coarse}));
  for (const double part : {0.05, 0.4, 0.9}) {
    SCOPED_TRACE(part);
    IsosurfaceRequest budgeted = request;
    budgeted.max_bytes = static_cast<std::uint64_t>(1.1 * least + part * (all - least));
    const BudgetedSurface made = within(budgeted);
    const double bytes = bytes_of(made.surface);
    EXPECT_LE(bytes, static_cast<double>(budgeted.max_bytes));
    EXPECT_GE(bytes, std::min(0.9 * static_cast<double>(budgeted.max_bytes), all));
    expect_good(made, budgeted);
  }
}

TEST_P(BudgetedSurfaces, EqualTheRequestWithALargeBudget) {
  IsosurfaceRequest request{.isovalue = kIsovalue, .error = 0.5, .simplify = true};
  const TiledMesh own = extractor_.extract({.request = request});
  request.max_triangles = mesh_of(own).triangles.size();
  const BudgetedSurface made = within(request);
  EXPECT_EQ(made.error_floor, 0);
  ASSERT_EQ(made.surface.tiles.size(), own.tiles.size());
  for (std::size_t t = 0; t < own.tiles.size(); ++t) {
    EXPECT_EQ(made.surface.tiles[t].mesh.triangles, own.tiles[t].mesh.triangles);
  }
}

TEST_P(BudgetedSurfaces, FallBackToTheCoarsest) {
  const IsosurfaceRequest request{
      .isovalue = kIsovalue, .error = 0.5, .max_triangles = 1, .simplify = true};
  const BudgetedSurface made = within(request);
  IsosurfaceRequest coarsest = request;
  coarsest.error = 1 << info_.grid_exponent;
  EXPECT_EQ(mesh_of(made.surface).triangles.size(), whole(coarsest).triangles.size());
  expect_good(made, request);
}

// With `intersection_free`, no surface intersects itself, however many collapses were undone.
TEST_P(BudgetedSurfaces, RespectThresholdMapsAndStayEmbedded) {
  std::mt19937_64 random(17);
  for (int i = 0; i < 2; ++i) {
    SCOPED_TRACE(i);
    IsosurfaceRequest request{.isovalue = kIsovalue,
                              .error = between(0, 1, random),
                              .unit = ErrorUnit::kWorld,
                              .thresholds = random_thresholds(info_, random),
                              .simplify = true,
                              .intersection_free = i % 2 == 1};
    const double all = static_cast<double>(whole(request).triangles.size());
    request.max_triangles = static_cast<std::uint64_t>(0.7 * all);
    const BudgetedSurface made = within(request);
    expect_good(made, request);
    if (request.intersection_free) {
      EXPECT_EQ(lattice_intersections(mesh_of(made.surface)).pairs, 0U);
    }
  }
}

// Only places whose threshold is below the reported floor lose detail, down to that floor.
TEST_P(BudgetedSurfaces, CoarsenTheFinestRegionsFirst) {
  constexpr double kCoarse = 3;
  IsosurfaceRequest request{.isovalue = kIsovalue, .error = kCoarse, .simplify = true};
  const auto coarse = static_cast<double>(whole(request).triangles.size());
  const double middle = info_.dims[2] / 2.0;
  request.thresholds = {.coordinates = CoordinateSystem::kIndex,
                        .regions = {{.shape = HalfSpaceShape{.normal = {0, 0, 1}, .offset = middle},
                                     .threshold = 0.1}}};
  const auto all = static_cast<double>(whole(request).triangles.size());
  ASSERT_GT(all, 1.5 * coarse);
  request.max_triangles = static_cast<std::uint64_t>(coarse + 0.6 * (all - coarse));
  const BudgetedSurface made = within(request);
  EXPECT_GT(made.error_floor, 0.1);
  EXPECT_LT(made.error_floor, kCoarse) << "The coarse half has the requested error.";
  expect_good(made, request);
}

TEST_P(BudgetedSurfaces, AreIndependentOfThreadCount) {
  IsosurfaceRequest request{.isovalue = kIsovalue, .error = 0.1, .simplify = true};
  request.max_triangles = whole(request).triangles.size() / 2;
  const BudgetedSurface of_all = within(request);
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  const BudgetedSurface of_one = within(request);
  EXPECT_EQ(of_one.error_floor, of_all.error_floor);
  ASSERT_EQ(of_one.surface.tiles.size(), of_all.surface.tiles.size());
  for (std::size_t t = 0; t < of_one.surface.tiles.size(); ++t) {
    const TileMesh& one = of_one.surface.tiles[t];
    const TileMesh& all = of_all.surface.tiles[t];
    EXPECT_EQ(one.cube, all.cube);
    EXPECT_EQ(one.mesh.vertices, all.mesh.vertices);
    EXPECT_EQ(one.mesh.triangles, all.mesh.triangles);
    EXPECT_EQ(one.simplification_bound, all.simplification_bound);
  }
}

// The other fields are so small that simplification begins with the requested error.
TEST(LargeBudgetedSurfaces, UseNearlyAllOfTheirBudget) {
  const DatasetPtr dataset = prepared({"large_noise", fields::noise({56, 56, 56}, 47)});
  const SurfaceExtractor extractor(dataset);
  IsosurfaceRequest request{.isovalue = 0.1, .error = 0, .simplify = true};
  const std::size_t all = mesh_of(extractor.extract({.request = request})).triangles.size();
  ASSERT_GT(all, 200'000U);
  IsosurfaceRequest coarse = request;
  coarse.error = 1e3;
  const std::size_t least = mesh_of(extractor.extract({.request = coarse})).triangles.size();
  request.max_triangles = least + (all - least) / 3;
  const BudgetedSurface made = surface_within_budget(extractor, request, bytes_of, {});
  const std::size_t triangles = mesh_of(made.surface).triangles.size();
  EXPECT_LE(triangles, request.max_triangles);
  EXPECT_GE(static_cast<double>(triangles), 0.97 * static_cast<double>(request.max_triangles));
  EXPECT_GT(made.error_floor, 0);
}

TEST(LargeBudgetedSurfaces, SortTheirTilesIfNothingIsSimplified) {
  const SurfaceExtractor extractor(prepared({"large_noise", fields::noise({56, 56, 56}, 47)}));
  IsosurfaceRequest request{.isovalue = 0.1, .error = 0, .simplify = true};
  const std::size_t all = mesh_of(extractor.extract({.request = request})).triangles.size();
  request.max_triangles = all;
  const BudgetedSurface made = surface_within_budget(extractor, request, bytes_of, {});
  EXPECT_EQ(mesh_of(made.surface).triangles.size(), all);
  EXPECT_GT(made.surface.tiles.size(), 8U);
  EXPECT_TRUE(std::ranges::is_sorted(made.surface.tiles, {}, &TileMesh::cube));
}

// Whatever the estimate says.
TEST(LargeBudgetedSurfaces, EqualTheRequestWithABudgetThatItMeets) {
  std::mt19937_64 random(48);
  const DatasetPtr dataset = prepared(
      {"large_noisy_ball", fields::sampled<float>({128, 128, 128}, [&random](int x, int y, int z) {
         const double noise = 40 * fields::uniform(random) - 20;
         return 100 * (58 - std::hypot(x - 63.3, y - 64.1, z - 63.7)) + noise;
       })});
  const SurfaceExtractor extractor(dataset);
  IsosurfaceRequest request{.isovalue = 0, .error = 0.5, .simplify = true};
  const std::size_t own = mesh_of(extractor.extract({.request = request})).triangles.size();
  for (const double part : {1.0, 1.2, 1.6}) {
    request.max_triangles = static_cast<std::uint64_t>(part * static_cast<double>(own));
    const BudgetedSurface made = surface_within_budget(extractor, request, bytes_of, {});
    EXPECT_EQ(made.error_floor, 0) << part;
    EXPECT_EQ(mesh_of(made.surface).triangles.size(), own) << part;
  }
}

// A budget must not give a larger error than a plain request of the same size.
TEST(SmallBudgetedSurfaces, AreNoWorseThanPlainRequestsOfTheirSize) {
  const DatasetPtr dataset =
      prepared({"torus", fields::sampled<float>({97, 97, 97}, [](int x, int y, int z) {
                  return 12 - std::hypot(std::hypot(x - 47.3, y - 48.1) - 28, z - 47.7);
                })});
  const SurfaceExtractor extractor(dataset);
  for (const double error : {0.1, 0.2, 0.4}) {
    const IsosurfaceRequest plain{.isovalue = 0, .error = error, .simplify = true};
    IsosurfaceRequest budgeted{.isovalue = 0, .error = 0, .simplify = true};
    budgeted.max_triangles = mesh_of(extractor.extract({.request = plain})).triangles.size();
    const BudgetedSurface made = surface_within_budget(extractor, budgeted, bytes_of, {});
    EXPECT_LE(made.error_floor, 1.5 * error) << budgeted.max_triangles;
  }
}

}  // namespace
}  // namespace multitetra::testing
