// Embedded simplified surfaces do not intersect themselves, whatever the error and tiles.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "common/mesh/content_digest.hpp"
#include "common/mesh/mesh_checks.hpp"
#include "server/extraction/detail/simplified_surface.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "tests/support/lattice_intersections.hpp"
#include "tests/support/prepared_fields.hpp"
#include "tests/support/tiled_surfaces.hpp"

namespace multitetra::testing {
namespace {

class EmbeddedSurfaces : public ::testing::TestWithParam<PreparedSetting> {};

std::vector<PreparedSetting> crowded_fields() {
  return {{"noise", fields::noise({15, 17, 14}, 41)},
          {"noisy_gyroid", fields::gyroid(36, 0.8, 45, {1, 1, 2})},
          {"closed_noise", fields::noise({18, 16, 17}, 42), 0.0, 1},
          {"adaptive_ball", fields::ball({50, 46, 52}, 18)}};
}
INSTANTIATE_TEST_SUITE_P(Fields, EmbeddedSurfaces, ::testing::ValuesIn(crowded_fields()),
                         [](const auto& parameter) { return std::string(parameter.param.name); });

TEST_P(EmbeddedSurfaces, HaveNoSelfIntersections) {
  const DatasetPtr dataset = prepared(GetParam());
  const DatasetInfo& info = dataset->info;
  const SurfaceExtractor extractor(dataset);
  const DataBorder border = data_border(info, kDefaultLatticeResolution, 0);
  std::size_t plain_pairs = 0;
  for (const double model_error : {0.0, 0.3}) {
    const TiledMesh model = extractor.extract({.request = {.isovalue = 0.3, .error = model_error}});
    const MeshTopology expected = topology(mesh_of(model), border);
    ASSERT_EQ(lattice_intersections(mesh_of(model)).pairs, 0U);
    for (const double error : {0.5, 4.0}) {
      for (const std::size_t triangles : {std::size_t{64'000}, std::size_t{500}}) {
        SCOPED_TRACE(::testing::Message() << model_error << " " << error << " " << triangles);
        const auto simplified = [&](bool is_intersection_free) {
          SimplificationOptions options{.max_distance = error * voxel_length(info),
                                        .is_intersection_free = is_intersection_free};
          for (std::size_t axis = 0; axis < 3; ++axis) {
            options.lattice_step[axis] = info.spacing[axis] / (1 << kDefaultLatticeResolution);
          }
          SurfaceSimplifier surface(options.lattice_step, info.grid_exponent);
          for (const TileMesh& tile : model.tiles) surface.add(tile, options, {});
          surface.simplify(options, {}, {.triangles = triangles});
          return mesh_of({.tiles = surface.tiles()});
        };
        const LatticeMesh embedded = simplified(true);
        EXPECT_EQ(lattice_intersections(embedded).pairs, 0U);
        const MeshTopology found = topology(embedded, border);
        EXPECT_TRUE(found.is_sound());
        EXPECT_EQ(found.euler_characteristic, expected.euler_characteristic);
        EXPECT_EQ(found.components, expected.components);
        const LatticeMesh plain = simplified(false);
        plain_pairs += lattice_intersections(plain).pairs;
        EXPECT_LE(static_cast<double>(embedded.triangles.size()),
                  1.5 * static_cast<double>(plain.triangles.size()) + 100);
        EXPECT_LT(embedded.triangles.size(), mesh_of(model).triangles.size());
      }
    }
  }
  if (GetParam().name != "adaptive_ball") {
    EXPECT_GT(plain_pairs, 0U) << "Nothing is at stake.";
  }
}

}  // namespace
}  // namespace multitetra::testing
