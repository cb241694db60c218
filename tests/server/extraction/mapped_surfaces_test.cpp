// Surfaces with random threshold maps: no cracks, the topology of the full-resolution surface, and
// a tighter map only refines; for models of exact errors and for prepared volumes.

#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "server/core/errors/leaves.hpp"
#include "server/extraction/reference_extractor.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "tests/support/distance.hpp"
#include "tests/support/isosurfaces.hpp"
#include "tests/support/prepared_fields.hpp"
#include "tests/support/threshold_maps.hpp"
#include "tests/support/tiled_surfaces.hpp"

namespace multitetra::testing {
namespace {

struct Setting {
  std::string name;
  Volume volume;
  std::optional<double> outside;
  std::int32_t margin;
  double isovalue;
};

std::ostream& operator<<(std::ostream& out, const Setting& setting) { return out << setting.name; }

std::vector<Setting> settings() {
  Volume sheared = fields::gyroid(27, 0.6, 46, {1, 1, 2});
  sheared.index_to_world = {.columns = {Vec3{0.9, 0.4, 0.1}, Vec3{-0.4, 0.9, 0}, Vec3{0.2, 0, 2}},
                            .translation = {-30, 12, 5}};
  return {
      {"noise", fields::noise({17, 20, 15}, 41), std::nullopt, 0, 0.4},
      {"closed_noise", fields::noise({14, 15, 12}, 42), 0.0, 1, 0.6},
      {"stretched_noise", fields::noise({21, 9, 12}, 43, {0.5, 1, 3}), std::nullopt, 2, 0.5},
      {"plateaus", fields::integer_noise({17, 16, 15}, 5, 44), std::nullopt, 0, 1.5},
      {"noisy_gyroid", fields::gyroid(33, 0.8, 45), std::nullopt, 0, 0.1},
      {"sheared_gyroid", std::move(sheared), std::nullopt, 0, 0.1},
      {"ball", fields::ball({33, 28, 40}, 11), 0.0, 1, 0.2},
  };
}

constexpr int kMaps = 12;  // For each field.

IsosurfaceRequest request_of(const Case& c) {
  return {.isovalue = c.isovalue,
          .error = c.threshold,
          .unit = ErrorUnit::kWorld,
          .error_measure = c.error_measure,
          .topology_rule = c.rule,
          .thresholds = c.thresholds};
}

class MappedSurfaces : public ::testing::TestWithParam<Setting> {
 protected:
  const Setting& setting_ = GetParam();

  // Calls `visit(case)` for random maps under all error measures and topology rules.
  template <typename RequestContext>
  void for_random_maps(const DatasetInfo& info, const RequestContext& visit) {
    std::mt19937_64 random(setting_.name.size());
    for (int i = 0; i < kMaps; ++i) {
      SCOPED_TRACE(i);
      Case c{.isovalue = setting_.isovalue,
             .threshold = between(0, 5, random),
             .error_measure = i % 2 == 0 ? ErrorMeasure::kCertified : ErrorMeasure::kPaper,
             .rule = i % 4 < 2 ? TopologyRule::kExact : TopologyRule::kPaper,
             .thresholds = random_thresholds(info, random)};
      visit(c);
    }
  }

  // Compares surfaces of a prepared dataset, with or without stored errors, with the reference.
  void match_the_reference(bool samples_only) {
    SCOPED_TRACE(samples_only ? "without errors" : "with errors");
    const DatasetPtr dataset =
        prepared({setting_.name, setting_.volume, setting_.outside, setting_.margin, samples_only});
    const SurfaceExtractor extractor(dataset);
    const ReferenceExtractor reference(*dataset);
    const DataBorder border = data_border(dataset->info, kDefaultLatticeResolution, 0);
    const MeshTopology full =
        topology(mesh_of(reference.surface(UniformModel(grid_of(dataset->info), 1000),
                                           {.isovalue = setting_.isovalue})),
                 border);
    for_random_maps(dataset->info, [&](const Case& c) {
      const StepRequest step{.request = request_of(c)};
      const TiledMesh fast = extractor.extract(step);
      const TiledMesh slow =
          dataset->info.grid_exponent > kSpectrumExponent
              ? reference.surface(*reference.spectrum_model(resolved_step(step, dataset->info)),
                                  {.isovalue = c.isovalue})
              : reference.extract(resolved_step(step, dataset->info));
      EXPECT_EQ(fast.tetrahedra, slow.tetrahedra);
      const LatticeMesh mesh = mesh_of(fast);
      EXPECT_EQ(digest(mesh), digest(mesh_of(slow)));
      const MeshTopology found = topology(mesh, border);
      EXPECT_TRUE(found.is_sound());
      EXPECT_EQ(found.euler_characteristic, full.euler_characteristic);
      EXPECT_EQ(found.components, full.components);
    });
  }
};
INSTANTIATE_TEST_SUITE_P(Fields, MappedSurfaces, ::testing::ValuesIn(settings()),
                         [](const auto& p) { return p.param.name; });

TEST_P(MappedSurfaces, HaveNoCrackAndTheTopologyOfTheFullSurface) {
  ReferenceIsosurfaces isosurface(setting_.volume, setting_.outside, setting_.margin);
  const Field& field = isosurface.field();
  const MeshTopology full =
      surface_of_model(UniformModel(field.grid(), 1000), field, setting_.isovalue, {}).topology;
  for_random_maps(isosurface.info(), [&](const Case& c) {
    const MeshTopology found = isosurface(c).topology;
    EXPECT_TRUE(found.is_sound());
    EXPECT_EQ(found.euler_characteristic, full.euler_characteristic);
    EXPECT_EQ(found.components, full.components);
  });
}

TEST_P(MappedSurfaces, MatchTheReferenceForPreparedVolumes) {
  for (const bool samples_only : {false, true}) match_the_reference(samples_only);
}

// The map with every threshold multiplied by `factor`.
LocalThresholds scaled(LocalThresholds thresholds, double factor) {
  thresholds.error_floor *= factor;
  for (ThresholdRegion& region : thresholds.regions) region.threshold *= factor;
  if (thresholds.grid) {
    auto grid = std::make_shared<ThresholdGrid>(*thresholds.grid);
    for (float& threshold : grid->thresholds) threshold *= static_cast<float>(factor);
    thresholds.grid = std::move(grid);
  }
  if (thresholds.view) {
    thresholds.view->tolerance_pixels *= factor;
    if (thresholds.view->frustum) thresholds.view->frustum->outside *= factor;
  }
  return thresholds;
}

TEST_P(MappedSurfaces, KeepAllPointsOfALooserMap) {
  ReferenceIsosurfaces isosurface(setting_.volume, setting_.outside, setting_.margin);
  const Grid& grid = isosurface.field().grid();
  for_random_maps(isosurface.info(), [&](const Case& c) {
    Case half = c;
    half.threshold *= 0.5;
    half.thresholds = scaled(c.thresholds, 0.5);
    const ErrorBasedModel loose = isosurface.model(c);
    const ErrorBasedModel tight = isosurface.model(half);
    for (std::int32_t z = 0; z <= grid.side(); ++z) {
      for (std::int32_t y = 0; y <= grid.side(); ++y) {
        for (std::int32_t x = 0; x <= grid.side(); ++x) {
          if (x % grid.side() == 0 && y % grid.side() == 0 && z % grid.side() == 0) continue;
          const DividingPoint point({x, y, z});
          if (!loose.kept(point)) continue;
          ASSERT_TRUE(tight.kept(point)) << x << " " << y << " " << z;
          for (const GridPoint parent : point.parents(grid)) {
            ASSERT_TRUE(loose.kept(DividingPoint(parent))) << x << " " << y << " " << z;
          }
        }
      }
    }
  });
}

// Checks the certified bound at every place; distances are in voxels.
TEST(MappedSurface, StaysWithinTheAllowedDistance) {
  const Volume volume = fields::gyroid(17, 0.4, 48);
  ReferenceIsosurfaces isosurface(volume, std::nullopt, 0);
  const DatasetInfo info = isosurface.info();
  const auto triangles_of = [](const LatticeMesh& mesh) {
    std::vector<Triangle> triangles;
    for (const TriangleIndices& t : mesh.triangles) {
      Triangle triangle;
      for (std::size_t i = 0; i < 3; ++i) {
        triangle[i] = grid_coordinates(mesh.vertices[t[i]], mesh.resolution);
      }
      triangles.push_back(triangle);
    }
    return triangles;
  };
  const double snapping = 2 * std::sqrt(3.0) / (1 << kMaxLatticeResolution);
  const auto full =
      triangles_of(surface_of_model(UniformModel(isosurface.field().grid(), 1000),
                                    isosurface.field(), 0.1, {}, kMaxLatticeResolution)
                       .mesh);
  std::mt19937_64 random(5);
  for (int i = 0; i < 6; ++i) {
    const Case c{.isovalue = 0.1,
                 .threshold = 3,
                 .error_measure = ErrorMeasure::kCertified,
                 .rule = TopologyRule::kExact,
                 .lattice_resolution = kMaxLatticeResolution,
                 .thresholds = random_thresholds(info, random)};
    const IsosurfaceRequest request = request_of(c);
    const auto mapped = triangles_of(isosurface(c).mesh);
    const auto expect_near = [&](const std::vector<Triangle>& from,
                                 const std::vector<Triangle>& to) {
      for (std::size_t t = 0; t < from.size(); t += from.size() / 150 + 1) {
        for (const Vec3& corner : from[t]) {
          double nearest = std::numeric_limits<double>::infinity();
          for (const Triangle& other : to) {
            nearest = std::min(nearest, distance_to_triangle(corner, other));
          }
          EXPECT_LE(nearest, threshold_at(request, info, corner) + snapping + 1e-9);
        }
      }
    };
    expect_near(mapped, full);
    expect_near(full, mapped);
  }
}

TEST(MappedSurface, IsFineInARegionAndCoarseElsewhere) {
  const Volume volume = fields::gyroid(65, 0.4, 47);
  ReferenceIsosurfaces isosurface(volume, std::nullopt, 0);
  const auto fine_ball = [](double threshold) {
    return Case{.isovalue = 0.1,
                .threshold = 4,
                .error_measure = ErrorMeasure::kCertified,
                .rule = TopologyRule::kExact,
                .thresholds = {.regions = {{.shape = BallShape{.center = {32, 32, 32}, .radius = 9},
                                            .threshold = threshold}}}};
  };
  // Compares the numbers of triangles whose first vertex lies in the ball.
  const Surface full =
      surface_of_model(UniformModel(isosurface.field().grid(), 1000), isosurface.field(), 0.1, {});
  const auto triangles_in_ball = [](const Surface& surface) {
    std::size_t count = 0;
    for (const TriangleIndices& t : surface.mesh.triangles) {
      const Vec3 p = grid_coordinates(surface.mesh.vertices[t[0]], surface.mesh.resolution);
      count += std::hypot(p[0] - 32, p[1] - 32, p[2] - 32) < 9;
    }
    return static_cast<double>(count);
  };
  const Surface mixed = isosurface(fine_ball(0));
  const Surface coarse = isosurface(fine_ball(4));
  EXPECT_GT(triangles_in_ball(mixed), 0.9 * triangles_in_ball(full));
  EXPECT_LT(triangles_in_ball(coarse), 0.7 * triangles_in_ball(full));
  EXPECT_LT(static_cast<double>(mixed.mesh.triangles.size()),
            1.2 * static_cast<double>(coarse.mesh.triangles.size()));
  EXPECT_LT(static_cast<double>(mixed.mesh.triangles.size()),
            0.7 * static_cast<double>(full.mesh.triangles.size()));
}

}  // namespace
}  // namespace multitetra::testing
