// Simplified surfaces under threshold maps: every place is within its threshold of the full
// surface, and coarse regions cost no more than they would alone.
#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <cmath>
#include <optional>
#include <ostream>
#include <random>
#include <string>
#include <vector>

#include "common/mesh/mesh_checks.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "tests/support/distance_statistics.hpp"
#include "tests/support/lattice_intersections.hpp"
#include "tests/support/prepared_fields.hpp"
#include "tests/support/public_volumes.hpp"
#include "tests/support/threshold_maps.hpp"
#include "tests/support/tiled_surfaces.hpp"

namespace multitetra::testing {
namespace {

class LocallySimplified : public ::testing::TestWithParam<PreparedSetting> {};

std::vector<PreparedSetting> fields_with_maps() {
  return {{"noisy_gyroid", fields::gyroid(40, 0.6, 45)},
          {"stretched_gyroid", fields::gyroid(33, 0.3, 46, {1, 1, 2})},
          {"closed_noise", fields::noise({24, 25, 22}, 42), 0.0, 1},
          {"ball", fields::ball({40, 38, 44}, 15)}};
}
INSTANTIATE_TEST_SUITE_P(Fields, LocallySimplified, ::testing::ValuesIn(fields_with_maps()),
                         [](const auto& parameter) { return std::string(parameter.param.name); });

TEST_P(LocallySimplified, StaysWithinTheLocalThresholds) {
  const DatasetPtr dataset = prepared(GetParam());
  const DatasetInfo& info = dataset->info;
  const SurfaceExtractor extractor(dataset);
  const double isovalue = 0.1;
  const LatticeMesh full =
      mesh_of(extractor.extract({.request = {.isovalue = isovalue, .error = 0}}));
  const auto full_surface = placed(full, info);
  const NearestTriangle to_full(full_surface);
  const DataBorder border = data_border(info, kDefaultLatticeResolution, 0);
  const MeshTopology expected = topology(full, border);
  // Both surfaces are rounded to the lattice.
  const double rounding = 2 * std::hypot(info.spacing[0], info.spacing[1], info.spacing[2]) /
                          (1 << kDefaultLatticeResolution);
  std::mt19937_64 random(17);
  for (int i = 0; i < 16; ++i) {
    SCOPED_TRACE(i);
    const IsosurfaceRequest request{.isovalue = isovalue,
                                    .error = between(0, 4, random),
                                    .unit = ErrorUnit::kWorld,
                                    .thresholds = random_thresholds(info, random),
                                    .simplify = true};
    const LatticeMesh small = mesh_of(extractor.extract({.request = request}));
    const MeshTopology found = topology(small, border);
    EXPECT_TRUE(found.is_sound());
    EXPECT_EQ(found.euler_characteristic, expected.euler_characteristic);
    EXPECT_EQ(found.components, expected.components);
    const auto allowed = [&](const Vec3& place) {
      const Vec3 grid = {place[0] / info.spacing[0], place[1] / info.spacing[1],
                         place[2] / info.spacing[2]};
      return threshold_at(request, info, grid) + rounding;
    };
    const auto surface = placed(small, info);
    const DistanceStatistics away = distances(sampled_points(surface, 8000), to_full, allowed);
    const DistanceStatistics back =
        distances(sampled_points(full_surface, 8000), NearestTriangle(surface), allowed);
    EXPECT_EQ(away.above_limit, 0U) << away.worst_distance << " of " << away.worst_limit;
    EXPECT_EQ(back.above_limit, 0U) << back.worst_distance << " of " << back.worst_limit;
  }
}

TEST_P(LocallySimplified, IsIndependentOfThreadCount) {
  const DatasetPtr dataset = prepared(GetParam());
  const SurfaceExtractor extractor(dataset);
  std::mt19937_64 random(18);
  IsosurfaceRequest request{.isovalue = 0.1, .error = 1, .simplify = true};
  for (int i = 0; i < 3; ++i) {
    SCOPED_TRACE(i);
    if (i == 1) request.thresholds = random_thresholds(dataset->info, random);
    request.intersection_free = i == 2;
    const TiledMesh of_all = extractor.extract({.request = request});
    const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
    const TiledMesh of_one = extractor.extract({.request = request});
    ASSERT_EQ(of_one.tiles.size(), of_all.tiles.size());
    for (std::size_t t = 0; t < of_one.tiles.size(); ++t) {
      EXPECT_EQ(of_one.tiles[t].cube, of_all.tiles[t].cube);
      EXPECT_EQ(of_one.tiles[t].mesh.vertices, of_all.tiles[t].mesh.vertices);
      EXPECT_EQ(of_one.tiles[t].mesh.triangles, of_all.tiles[t].mesh.triangles);
      EXPECT_EQ(of_one.tiles[t].simplification_bound, of_all.tiles[t].simplification_bound);
    }
    if (request.intersection_free) {
      EXPECT_EQ(lattice_intersections(mesh_of(of_one)).pairs, 0U);
    }
  }
}

// A field and the error allowed outside a region.
struct MappedField {
  std::string name;
  std::optional<Volume> volume;  // Empty if the volume is not on this machine.
  double isovalue = 0.1;
  double coarse = 2;
};

std::ostream& operator<<(std::ostream& out, const MappedField& field) { return out << field.name; }

class ThresholdMapCost : public ::testing::TestWithParam<MappedField> {
 protected:
  void SetUp() override {
    if (!GetParam().volume) {
      GTEST_SKIP() << "NOT TESTED: the public volumes are not at " << MULTITETRA_PUBLIC_DATA;
    }
    extractor_.emplace(prepared({GetParam().name, *GetParam().volume}));
  }
  [[nodiscard]] LatticeMesh surface(double error, LocalThresholds thresholds = {}) const {
    return mesh_of(extractor_->extract({.request = {.isovalue = GetParam().isovalue,
                                                    .error = error,
                                                    .thresholds = std::move(thresholds),
                                                    .simplify = true}}));
  }
  // The number of triangles with a corner in a box of samples.
  [[nodiscard]] static double count_in(const LatticeMesh& mesh, const BoxShape& box) {
    double count = 0;
    for (const TriangleIndices& t : mesh.triangles) {
      for (const std::uint32_t v : t) {
        const Vec3 p = grid_coordinates(mesh.vertices[v], mesh.resolution);
        bool is_inside = true;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          is_inside = is_inside && box.low[axis] <= p[axis] && p[axis] <= box.high[axis];
        }
        if (!is_inside) continue;
        ++count;
        break;
      }
    }
    return count;
  }
  [[nodiscard]] static LocalThresholds fine_in(const BoxShape& box, double threshold) {
    return {.coordinates = CoordinateSystem::kIndex,
            .regions = {{.shape = box, .threshold = threshold}}};
  }
  [[nodiscard]] static double triangles(const LatticeMesh& mesh) {
    return static_cast<double>(mesh.triangles.size());
  }

  // A box of all samples between two planes along z.
  [[nodiscard]] BoxShape between_planes(double low, double high) const {
    const auto& dims = GetParam().volume->dims;
    return {.low = {-1, -1, low}, .high = {1.0 * dims[0], 1.0 * dims[1], high}};
  }

  std::optional<SurfaceExtractor> extractor_;
};

std::vector<MappedField> mapped_fields() {
  return {{"gyroid", fields::gyroid(97, 0.1, 45)}, {"ct_head", ct_head(), 500, 4}};
}
INSTANTIATE_TEST_SUITE_P(Fields, ThresholdMapCost, ::testing::ValuesIn(mapped_fields()),
                         [](const auto& parameter) { return std::string(parameter.param.name); });

TEST_P(ThresholdMapCost, IsLocalForASmallBox) {
  const LatticeMesh coarse = surface(GetParam().coarse);
  const LatticeMesh fine = surface(0.25);
  const Vec3 p = grid_coordinates(fine.vertices[fine.vertices.size() / 2], fine.resolution);
  const BoxShape box{.low = {p[0] - 2, p[1] - 2, p[2] - 2}, .high = {p[0] + 2, p[1] + 2, p[2] + 2}};
  const LatticeMesh mixed = surface(GetParam().coarse, fine_in(box, 0.25));
  EXPECT_GT(triangles(fine), 4 * triangles(coarse)) << "There is something to gain.";
  EXPECT_LE(triangles(mixed), 1.3 * triangles(coarse) + count_in(fine, box));
  EXPECT_GE(count_in(mixed, box), 0.5 * count_in(fine, box)) << "It is fine in the box.";
}

TEST_P(ThresholdMapCost, IsLittleMoreThanTheHalvesForTwoHalves) {
  const double end = GetParam().volume->dims[2];
  const double middle = std::floor(end / 2);
  const BoxShape half = between_planes(-1, middle);
  const BoxShape other = between_planes(middle, end);
  const LatticeMesh coarse = surface(GetParam().coarse);
  const LatticeMesh fine = surface(0.25);
  const LatticeMesh mixed = surface(GetParam().coarse, fine_in(half, 0.25));
  EXPECT_LE(triangles(mixed), 1.1 * (count_in(fine, half) + count_in(coarse, other)));
}

TEST_P(ThresholdMapCost, IsLowerForAViewThanItsLeastThresholdEverywhere) {
  const ThresholdView view{
      .eye = {48, 48, -20}, .field_of_view = 45, .height_pixels = 800, .tolerance_pixels = 10};
  const LatticeMesh seen = surface(1, {.coordinates = CoordinateSystem::kIndex, .view = view});
  // At the distance of the nearest sample.
  const LatticeMesh everywhere =
      surface(2 * std::tan(22.5 / 180 * 3.141592653589793) * 20 * 10 / 800);
  EXPECT_LT(triangles(seen), 0.5 * triangles(everywhere));
}

}  // namespace
}  // namespace multitetra::testing
