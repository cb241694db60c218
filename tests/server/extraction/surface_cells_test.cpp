// Surfaces requested one octree cube at a time: together they are the whole surface.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "common/mesh/content_digest.hpp"
#include "server/core/errors/leaves.hpp"
#include "server/core/spectrum/crossed_octants.hpp"
#include "server/extraction/reference_extractor.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "tests/support/prepared_fields.hpp"
#include "tests/support/tiled_surfaces.hpp"

namespace multitetra::testing {
namespace {

std::vector<OctreeCube> cubes_of(const DatasetInfo& info, int exponent) {
  const std::int32_t along = 1 << (info.grid_exponent - exponent);
  std::vector<OctreeCube> cubes;
  for (std::int32_t z = 0; z < along; ++z) {
    for (std::int32_t y = 0; y < along; ++y) {
      for (std::int32_t x = 0; x < along; ++x) cubes.push_back({exponent, x, y, z});
    }
  }
  return cubes;
}

StepRequest with_cell(IsosurfaceRequest request, const OctreeCube& cube,
                      std::int32_t finest_spacing = 1) {
  request.cell = OctreeNode{.cube = cube, .finest_spacing = finest_spacing};
  return final_step(request);
}

ContentDigest digest_of(const TiledMesh& surface) {
  ContentDigest sum;
  for (const TileMesh& tile : surface.tiles) sum += digest(tile.mesh);
  return sum;
}

// The first two of isovalues_of(), to save time.
std::vector<double> some_isovalues(const PreparedVolume& dataset) {
  std::vector<double> isovalues = isovalues_of(dataset);
  isovalues.resize(2);
  return isovalues;
}

class SurfaceCells : public ::testing::TestWithParam<PreparedSetting> {};
INSTANTIATE_TEST_SUITE_P(Fields, SurfaceCells, ::testing::ValuesIn(prepared_settings()),
                         [](const auto& p) { return p.param.name; });

TEST_P(SurfaceCells, ContainExactlyTheTrianglesOfTheModel) {
  const DatasetPtr dataset = prepared(GetParam());
  const SurfaceExtractor extractor(dataset);
  const ReferenceExtractor reference(*dataset);
  for (const double isovalue : some_isovalues(*dataset)) {
    for (const std::int32_t finest : {1, 8}) {
      for (int exponent = kMinCellExponent; exponent <= dataset->info.grid_exponent; ++exponent) {
        SCOPED_TRACE(::testing::Message() << "isovalue " << isovalue << ", finest spacing "
                                          << finest << ", exponent " << exponent);
        const IsosurfaceRequest request = {
            .isovalue = isovalue, .error = 0.7, .topology_tolerance = finest / 2.0};
        const std::vector<OctreeCube> cubes = cubes_of(dataset->info, exponent);
        ContentDigest sum;
        for (const OctreeCube& cube : cubes) {
          const TiledMesh surface = extractor.extract(with_cell(request, cube, finest));
          sum += digest_of(surface);
          for (const TileMesh& tile : surface.tiles) {
            EXPECT_TRUE(std::all_of(tile.mesh.vertices.begin(), tile.mesh.vertices.end(),
                                    [&](const LatticePoint& p) {
                                      return cube.contains(p, kDefaultLatticeResolution);
                                    }));
          }
        }
        // The model is the same for every cell of one size.
        const ResolvedStep spec =
            resolved_step(with_cell(request, cubes.front(), finest), dataset->info);
        const ContentDigest whole =
            digest_of(reference.surface(*reference.spectrum_model(spec), {.isovalue = isovalue}));
        EXPECT_EQ(sum.hex(), whole.hex());
      }
    }
  }
}

TEST_P(SurfaceCells, WeldToASurfaceOfTheSameTopologyEvenIfSimplified) {
  const DatasetPtr dataset = prepared(GetParam());
  const DatasetInfo& info = dataset->info;
  const SurfaceExtractor extractor(dataset);
  const DataBorder border = data_border(info, kDefaultLatticeResolution, 0);
  for (const double isovalue : some_isovalues(*dataset)) {
    const TiledMesh full = extractor.extract({.request = {.isovalue = isovalue, .error = 0}});
    const MeshTopology expected = topology(mesh_of(full), border);
    for (const int exponent : {kMinCellExponent, info.grid_exponent - 1}) {
      if (exponent < kMinCellExponent) continue;
      SCOPED_TRACE(::testing::Message() << "isovalue " << isovalue << ", exponent " << exponent);
      std::vector<TileMesh> tiles;
      for (const OctreeCube& cube : cubes_of(info, exponent)) {
        TiledMesh surface = extractor.extract(
            with_cell({.isovalue = isovalue, .error = 1, .simplify = true}, cube));
        std::move(surface.tiles.begin(), surface.tiles.end(), std::back_inserter(tiles));
      }
      const MeshTopology found = topology(weld(tiles, kDefaultLatticeResolution), border);
      EXPECT_EQ(found.euler_characteristic, expected.euler_characteristic);
      EXPECT_EQ(found.components, expected.components);
      EXPECT_EQ(found.open_edges, 0);
      EXPECT_EQ(found.nonmanifold_edges, 0);
      if (expected.triangles > 2000) {
        EXPECT_LT(found.triangles, expected.triangles);
      }
    }
  }
}

TEST_P(SurfaceCells, OmitOctantsWithoutSurfaceAtEveryError) {
  const DatasetPtr dataset = prepared(GetParam());
  const SurfaceExtractor extractor(dataset);
  for (const double isovalue : some_isovalues(*dataset)) {
    for (int exponent = kMinCellExponent + 1; exponent <= dataset->info.grid_exponent; ++exponent) {
      for (const OctreeCube& cube : cubes_of(dataset->info, exponent)) {
        const std::uint32_t crossed = crossed_octants(*dataset, cube, isovalue);
        for (int i = 0; i < 8; ++i) {
          if ((crossed >> i & 1U) != 0) continue;
          const OctreeCube child = cube.child(i);
          EXPECT_EQ(crossed_octants(*dataset, child, isovalue), 0U);
          for (const double error : {0.0, 1.0, 8.0}) {
            const StepRequest step = with_cell({.isovalue = isovalue, .error = error}, child);
            EXPECT_TRUE(extractor.extract(step).tiles.empty()) << to_string(child);
          }
        }
      }
    }
  }
}

TEST(OctreeNode, OmitsNothingWhereValuesLieOnBothSides) {
  const DatasetPtr dataset =
      prepared({"small_ball", fields::sampled<float>({65, 65, 65}, [](int x, int y, int z) {
                  return 6 - std::hypot(x - 20, y - 20, z - 30);
                })});
  const OctreeCube root = root_cube(grid_of(dataset->info));
  const double isovalue = 0.1;
  const std::uint32_t crossed = crossed_octants(*dataset, root, isovalue);
  EXPECT_EQ(crossed, 0x11U);  // The octants next to the origin and above it.
  const SurfaceExtractor extractor(dataset);
  for (int i = 0; i < 8; ++i) {
    const TiledMesh surface =
        extractor.extract(with_cell({.isovalue = isovalue, .error = 0}, root.child(i)));
    EXPECT_EQ((crossed >> i & 1U) != 0, !surface.tiles.empty()) << i;
  }
}

}  // namespace
}  // namespace multitetra::testing
