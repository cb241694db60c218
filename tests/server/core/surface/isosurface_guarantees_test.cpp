// The method's theorems, over fields x isovalues x thresholds: no model has a crack, the topology
// is that of the full-resolution surface at every threshold, the certified bound holds, and a
// tighter threshold only refines.

#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <set>

#include "common/mesh/content_digest.hpp"
#include "tests/support/distance.hpp"
#include "tests/support/fields.hpp"
#include "tests/support/isosurfaces.hpp"

namespace multitetra::testing {
namespace {

struct Setting {
  const char* name;
  Volume volume;
  std::optional<double> outside;
  std::int32_t margin;
  std::vector<double> isovalues;
  bool has_mask = false;
};

std::ostream& operator<<(std::ostream& out, const Setting& setting) { return out << setting.name; }

std::vector<Setting> settings() {
  return {
      {"noise", fields::noise({17, 17, 17}, 21), std::nullopt, 0, {0.3, 0.5}},
      {"flat_noise_in_zeros", fields::noise({21, 6, 9}, 22, {0.5, 1, 3}), 0.0, 0, {0.4}},
      {"closed_noise", fields::noise({14, 15, 12}, 23), 0.0, 1, {0.6, 0.9}},
      {"plateaus", fields::integer_noise({17, 16, 15}, 5, 24), std::nullopt, 0, {0, 1.5, 3}},
      {"plateaus_in_a_value", fields::integer_noise({15, 15, 15}, 3, 25), 2.0, 1, {0.5, 1}},
      {"gyroid", fields::gyroid(33, 0, 26), std::nullopt, 0, {0.1}},
      {"noisy_gyroid", fields::gyroid(33, 0.8, 27, {1, 1, 2}), std::nullopt, 0, {0.1}},
      {"ball", fields::ball({20, 24, 17}, 7), std::nullopt, 0, {0.0}},
      {"masked_gyroid", fields::masked_gyroid(24, 28), std::nullopt, 0, {0.05}, true},
      {"single_slice", fields::noise({17, 17, 1}, 29), 0.0, 1, {0.5}},
      {"single_sample", fields::noise({1, 1, 1}, 30), -1.0, 1, {0.0}},
  };
}

std::string name_of(const ::testing::TestParamInfo<Setting>& parameter) {
  return parameter.param.name;
}

class IsosurfaceGuarantees : public ::testing::TestWithParam<Setting> {
 protected:
  const Setting& setting_ = GetParam();
  ReferenceIsosurfaces isosurface_{setting_.volume, setting_.outside, setting_.margin};

  // Visits every combination of isovalue, error measure and topology rule.
  template <typename Visit>
  void for_each_case(const Visit& visit) {
    for (const double isovalue : setting_.isovalues) {
      for (const ErrorMeasure measure : {ErrorMeasure::kCertified, ErrorMeasure::kPaper}) {
        for (const TopologyRule rule : {TopologyRule::kExact, TopologyRule::kPaper}) {
          SCOPED_TRACE(::testing::Message() << "isovalue " << isovalue << ", " << name(measure)
                                            << ", rule " << name(rule));
          visit(Case{.isovalue = isovalue, .error_measure = measure, .rule = rule});
        }
      }
    }
  }
  // With masks inside the data, a surface may end at any of them.
  [[nodiscard]] bool is_sound(const MeshTopology& topology) const {
    return topology.nonmanifold_edges == 0 && topology.degenerate_triangles == 0 &&
           (topology.open_edges == 0 || setting_.has_mask);
  }
};
INSTANTIATE_TEST_SUITE_P(Fields, IsosurfaceGuarantees, ::testing::ValuesIn(settings()), name_of);

// Uses only the small fields, as distances are computed by brute force.
class CertifiedBound : public IsosurfaceGuarantees {};
std::vector<Setting> small_settings() {
  std::vector<Setting> small = settings();
  std::erase_if(small, [](const Setting& setting) { return setting.volume.size() > 6000; });
  return small;
}
INSTANTIATE_TEST_SUITE_P(SmallFields, CertifiedBound, ::testing::ValuesIn(small_settings()),
                         name_of);

constexpr double kThresholds[] = {0, 0.2, 0.5, 1, 2, 4, 1e9};

TEST_P(IsosurfaceGuarantees, HasNoCracksAtAnyThreshold) {
  for_each_case([&](Case c) {
    for (const double threshold : {0.0, 0.3, 1.0, 3.0}) {
      for (const double tolerance : {0.0, 1.0, 2.0, 5.0}) {
        for (const std::int32_t finest : {1, 2, 4}) {
          c.threshold = threshold;
          c.topology_tolerance = tolerance;
          c.finest_spacing = finest;
          const Surface surface = isosurface_(c);
          if (setting_.outside || tolerance + finest == 1) {
            EXPECT_TRUE(is_sound(surface.topology))
                << threshold << " " << tolerance << " " << finest;
          } else {
            // The inset of the data's border depends on the finest spacing.
            const MeshTopology checked = topology(surface.mesh, [&] {
              DatasetInfo info;
              info.dims = setting_.volume.dims;
              info.margin = setting_.margin;
              info.grid_exponent = isosurface_.field().grid().exponent();
              return data_border(info, c.lattice_resolution, tolerance, finest);
            }());
            EXPECT_TRUE(is_sound(checked)) << threshold << " " << tolerance << " " << finest;
          }
        }
      }
    }
  });
}

TEST_P(IsosurfaceGuarantees, KeepsTheTopologyOfTheFullSurfaceAtEveryThreshold) {
  const Field& field = isosurface_.field();
  const UniformModel full_resolution(field.grid(), 1000);
  for_each_case([&](Case c) {
    const MeshTopology full = surface_of_model(full_resolution, field, c.isovalue, {}).topology;
    for (const double threshold : kThresholds) {
      c.threshold = threshold;
      const MeshTopology coarse = isosurface_(c).topology;
      EXPECT_EQ(coarse.euler_characteristic, full.euler_characteristic) << threshold;
      EXPECT_EQ(coarse.components, full.components) << threshold;
    }
  });
}

std::vector<Triangle> world_triangles(const LatticeMesh& mesh, const Vec3& spacing) {
  std::vector<Vec3> positions;
  for (const LatticePoint& v : mesh.vertices) {
    const Vec3 p = grid_coordinates(v, mesh.resolution);
    positions.push_back({p[0] * spacing[0], p[1] * spacing[1], p[2] * spacing[2]});
  }
  std::vector<Triangle> triangles;
  for (const TriangleIndices& t : mesh.triangles) {
    triangles.push_back({positions[t[0]], positions[t[1]], positions[t[2]]});
  }
  return triangles;
}

TEST_P(CertifiedBound, BoundsTheDistanceToTheFullSurface) {
  const Vec3& spacing = setting_.volume.spacing;
  const double snapping =
      2 * length(spacing) / (1 << kMaxLatticeResolution);  // Once for each surface.
  for (const double isovalue : setting_.isovalues) {
    Case c{.isovalue = isovalue,
           .error_measure = ErrorMeasure::kCertified,
           .rule = TopologyRule::kExact,
           .lattice_resolution = kMaxLatticeResolution};
    const auto full =
        world_triangles(surface_of_model(UniformModel(isosurface_.field().grid(), 1000),
                                         isosurface_.field(), isovalue, {}, kMaxLatticeResolution)
                            .mesh,
                        spacing);
    for (const double threshold : {0.0, 0.5, 1.5, 1e9}) {
      c.threshold = threshold;
      const Surface surface = isosurface_(c);
      const auto coarse = world_triangles(surface.mesh, spacing);
      // Keeps a few hundred samples per case.
      const auto thinned = [](std::vector<Triangle> t) {
        const std::size_t step = t.size() / 60 + 1;
        std::vector<Triangle> some;
        for (std::size_t i = 0; i < t.size(); i += step) some.push_back(t[i]);
        return some;
      };
      EXPECT_LE(one_sided_distance(thinned(coarse), full), threshold + snapping) << threshold;
      EXPECT_LE(one_sided_distance(thinned(full), coarse), threshold + snapping) << threshold;
    }
  }
}

TEST_P(IsosurfaceGuarantees, OnlyRefinesWithATighterThreshold) {
  const Grid& grid = isosurface_.field().grid();
  for_each_case([&](Case c) {
    const auto errors = std::make_shared<const SaturatedErrors>(isosurface_.field(), c.isovalue,
                                                                c.error_measure, c.rule);
    const ErrorBasedModel loose(
        errors, {.thresholds = ThresholdMap::everywhere(1.3), .topology_tolerance = 1});
    const ErrorBasedModel tight(
        errors, {.thresholds = ThresholdMap::everywhere(0.4), .topology_tolerance = 0});
    for (std::int32_t z = 0; z <= grid.side(); ++z) {
      for (std::int32_t y = 0; y <= grid.side(); ++y) {
        for (std::int32_t x = 0; x <= grid.side(); ++x) {
          if (x % grid.side() == 0 && y % grid.side() == 0 && z % grid.side() == 0) continue;
          const DividingPoint point({x, y, z});
          if (loose.kept(point)) {
            ASSERT_TRUE(tight.kept(point)) << x << " " << y << " " << z;
          }
          if (!tight.kept(point)) continue;
          for (const GridPoint parent : point.parents(grid))
            ASSERT_TRUE(tight.kept(DividingPoint(parent)));
        }
      }
    }
  });
}

TEST_P(IsosurfaceGuarantees, DividesTheSurfaceIntoTilesOfAnySize) {
  const Field& field = isosurface_.field();
  const OctreeCube root = root_cube(field.grid());
  for (const double isovalue : setting_.isovalues) {
    const auto errors = std::make_shared<const SaturatedErrors>(
        field, isovalue, ErrorMeasure::kCertified, TopologyRule::kExact);
    const ErrorBasedModel model(errors, {.thresholds = ThresholdMap::everywhere(0.5)});
    const Surface whole = surface_of_model(model, field, isovalue, {});
    for (const std::size_t max_triangles : {std::size_t{1}, std::size_t{50}, std::size_t{700}}) {
      const auto tiles =
          finished_tiles(surface_in_cube(model, field, root,
                                         {.isovalue = isovalue, .max_triangles = max_triangles}),
                         root);
      ContentDigest sum;
      std::size_t triangles = 0;
      std::set<OctreeCube> cubes;
      std::vector<LatticeMesh> meshes;
      for (const auto& tile : tiles) {
        EXPECT_TRUE(cubes.insert(tile.cube).second) << to_string(tile.cube);
        EXPECT_FALSE(tile.mesh.triangles.empty());
        // A cube owns at most 48 tetrahedra of two triangles each, which are never split.
        EXPECT_LE(tile.mesh.triangles.size(), max_triangles + 96);
        triangles += tile.mesh.triangles.size();
        sum += digest(tile.mesh);
        for (const LatticePoint& p : tile.mesh.vertices) {
          EXPECT_TRUE(tile.cube.contains(p, kDefaultLatticeResolution));
        }
        meshes.push_back(tile.mesh);
      }
      EXPECT_EQ(triangles, whole.mesh.triangles.size());
      EXPECT_EQ(sum, digest(whole.mesh));
      EXPECT_EQ(topology(weld(meshes, kDefaultLatticeResolution), {}), whole.topology);
    }
  }
}

TEST_P(IsosurfaceGuarantees, HasNoVertexOnAGridPointAtFullResolution) {
  const Field& field = isosurface_.field();
  const UniformModel full(field.grid(), 1000);
  for (const int resolution : {1, 3, 5, 8}) {
    const Surface surface =
        surface_of_model(full, field, setting_.isovalues.front(), {}, resolution);
    const std::int32_t step = 1 << resolution;
    for (const LatticePoint& p : surface.mesh.vertices) {
      EXPECT_TRUE(is_on_lattice(p));
      EXPECT_FALSE(p.x % step == 0 && p.y % step == 0 && p.z % step == 0);
    }
    EXPECT_EQ(surface.topology.nonmanifold_edges, 0);
    EXPECT_EQ(surface.topology.degenerate_triangles, 0);
  }
}

TEST(Isosurface, EqualsTheFullResolutionAtThresholdZero) {
  const Volume volume = fields::noise({17, 16, 14}, 31);
  ReferenceIsosurfaces isosurface(volume, std::nullopt, 0);
  const Field& field = isosurface.field();
  const Surface full = surface_of_model(UniformModel(field.grid(), 1000), field, 0.5, {});
  const Surface lossless = isosurface({.isovalue = 0.5, .threshold = 0});
  EXPECT_EQ(digest(lossless.mesh), digest(full.mesh));
  EXPECT_LT(lossless.tetrahedra, full.tetrahedra);
}

TEST(Isosurface, IsEmptyOutsideTheValueRange) {
  const Volume volume = fields::noise({9, 9, 9}, 32);
  ReferenceIsosurfaces isosurface(volume, std::nullopt, 0);
  for (const double isovalue : {-1.0, 1.0, 1e300, -1e300}) {
    const Surface surface = isosurface({.isovalue = isovalue});
    EXPECT_EQ(surface.topology, MeshTopology{});
    EXPECT_EQ(surface.tetrahedra, 12U);
  }
}

TEST(Isosurface, IsAnOutwardFacingSphereForABall) {
  const Volume volume = fields::ball({20, 20, 20}, 7);
  ReferenceIsosurfaces isosurface(volume, std::nullopt, 0);
  for (const double threshold : {0.0, 0.3, 1.0}) {
    const Surface surface = isosurface({.isovalue = 0, .threshold = threshold});
    EXPECT_EQ(surface.topology.euler_characteristic, 2);
    EXPECT_EQ(surface.topology.components, 1);
    EXPECT_EQ(surface.topology.border_edges, 0);
    double volume_inside = 0;
    for (const Triangle& t : world_triangles(surface.mesh, {1, 1, 1})) {
      volume_inside += dot(t[0], cross(t[1], t[2])) / 6;
    }
    EXPECT_NEAR(volume_inside, 4.0 / 3 * 3.14159265 * 7 * 7 * 7, 0.12 * 1436) << threshold;
  }
}

}  // namespace
}  // namespace multitetra::testing
