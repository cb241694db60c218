// Sample shells of prepared datasets: they decode to what core's marching tetrahedra make of the
// uniform level, have the full surface's topology, and move vertices within their bound.

#include "server/extraction/shell_extractor.hpp"

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "common/base/in_parallel.hpp"
#include "common/mesh/merged_tiles.hpp"
#include "common/mesh/mesh_checks.hpp"
#include "common/wire/shell_tile.hpp"
#include "server/core/errors/leaves.hpp"
#include "server/extraction/reference_extractor.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "tests/support/prepared_fields.hpp"
#include "tests/support/sample_shells.hpp"

namespace multitetra::testing {
namespace {

using shell::ShellValues;

// Decodes each tile, in order.
std::vector<LatticeMesh> decoded(const std::vector<EncodedTile>& tiles) {
  std::vector<LatticeMesh> meshes;
  for (const EncodedTile& tile : tiles) {
    DecodedShell shell = decode_shell({tile.payload->begin(), tile.payload->end()});
    EXPECT_EQ(shell.status, shell::ShellStatus::kOk) << to_string(tile.summary.cube);
    EXPECT_EQ(shell.mesh.triangles.size(), tile.summary.triangles);
    EXPECT_EQ(shell.mesh.vertices.size(), tile.summary.vertices);
    EXPECT_EQ(tile.summary.bytes, tile.payload->size());
    EXPECT_EQ(tile.summary.digest, digest_of_bytes(*tile.payload));
    for (const LatticePoint& p : shell.mesh.vertices) {
      EXPECT_TRUE(tile.summary.cube.contains(p, shell.mesh.resolution));
    }
    meshes.push_back(std::move(shell.mesh));
  }
  return meshes;
}

LatticeMesh surface(const PreparedVolume& volume, const ShellLevel& level,
                    int max_cells = kShellCells) {
  return weld(decoded(extract_shells(volume, level, {}, max_cells)), level.lattice_resolution);
}

// The uniform level, made by the reference extractor.
LatticeMesh marched_level(const ReferenceExtractor& reference, const ShellLevel& level) {
  const Grid& grid = reference.field().grid();
  const UniformModel model(grid, 3 * (grid.exponent() - exponent_of(level.finest_spacing)) - 1);
  const TiledMesh tiles = reference.surface(
      model, {.isovalue = level.isovalue, .lattice_resolution = level.lattice_resolution});
  std::vector<LatticeMesh> meshes;
  for (const TileMesh& tile : tiles.tiles) meshes.push_back(tile.mesh);
  return weld(meshes, level.lattice_resolution);
}

ShellStep lossless(const PreparedVolume& volume) {
  const bool has_integers = volume.info.type != SampleType::kF32;
  return {.values = has_integers ? ShellValues::kExact : ShellValues::kLatticeExact};
}

class ExtractShells : public ::testing::TestWithParam<PreparedSetting> {};
INSTANTIATE_TEST_SUITE_P(Fields, ExtractShells, ::testing::ValuesIn(prepared_settings()),
                         [](const auto& p) { return p.param.name; });

TEST_P(ExtractShells, DecodesToTheMarchedLevel) {
  const DatasetPtr dataset = prepared(GetParam());
  const ReferenceExtractor reference(*dataset);
  const std::vector<double> between = isovalues_of(*dataset);
  for (const double isovalue : {between[0], std::floor(between[1])}) {  // Also at an integer.
    for (const std::int32_t spacing : {1, 2, 4, 8, 16}) {
      SCOPED_TRACE(::testing::Message() << "isovalue " << isovalue << ", spacing " << spacing);
      for (const ShellValues values : {ShellValues::kExact, ShellValues::kLatticeExact}) {
        const ShellLevel level = {.isovalue = isovalue,
                                  .lattice_resolution = 4,
                                  .finest_spacing = spacing,
                                  .shell = {.values = values}};
        if (!has_shells(dataset->info, level)) continue;
        const LatticeMesh expected = marched_level(reference, level);
        for (const int cells : {8, kShellCells}) {
          const LatticeMesh found = surface(*dataset, level, cells);
          EXPECT_EQ(found.vertices.size(), expected.vertices.size());
          EXPECT_EQ(sorted_triangles(found), sorted_triangles(expected));
        }
      }
    }
  }
}

TEST_P(ExtractShells, MovesVerticesAtMostByTheReportedBound) {
  const DatasetPtr dataset = prepared(GetParam());
  const Vec3& voxel = dataset->info.spacing;
  const double snapping = std::hypot(voxel[0], voxel[1], voxel[2]) / 256;
  for (const std::int32_t spacing : {1, 4}) {
    ShellLevel level = {.isovalue = isovalues_of(*dataset)[0],
                        .lattice_resolution = 8 - exponent_of(spacing),
                        .finest_spacing = spacing,
                        .shell = lossless(*dataset)};
    const auto exact = decoded(extract_shells(*dataset, level));
    for (const int levels : {1, 2, 4, 8}) {
      level.shell = quantized_shells(levels);
      const double bound = error_bound(level.shell, dataset->info, spacing);
      const auto moved = decoded(extract_shells(*dataset, level));
      ASSERT_EQ(moved.size(), exact.size());
      double farthest = 0;
      for (std::size_t i = 0; i < moved.size(); ++i) {
        ASSERT_EQ(moved[i].triangles.size(), exact[i].triangles.size());
        ASSERT_EQ(moved[i].vertices.size(), exact[i].vertices.size());
        for (std::size_t v = 0; v < moved[i].vertices.size(); ++v) {
          const LatticePoint& a = moved[i].vertices[v];
          const LatticePoint& b = exact[i].vertices[v];
          const double step = 1.0 / (1 << level.lattice_resolution);
          farthest = std::max(
              farthest, std::hypot((a.x - b.x) * step * voxel[0], (a.y - b.y) * step * voxel[1],
                                   (a.z - b.z) * step * voxel[2]));
        }
      }
      EXPECT_LE(farthest, bound + 2 * snapping * spacing) << levels << " levels";
    }
  }
}

TEST_P(ExtractShells, KeepsTheTopologyOfTheFullSurface) {
  const DatasetPtr dataset = prepared(GetParam());
  const SurfaceExtractor extractor(dataset);
  const DataBorder border = data_border(dataset->info, kDefaultLatticeResolution, 0);
  for (const double isovalue : isovalues_of(*dataset)) {
    const TiledMesh coarse = extractor.extract({.request = {.isovalue = isovalue, .error = 1}});
    const MeshTopology expected = topology(weld(coarse.tiles, kDefaultLatticeResolution), border);
    for (const ShellStep shell : {lossless(*dataset), quantized_shells(1), quantized_shells(4)}) {
      const MeshTopology found =
          topology(surface(*dataset, {.isovalue = isovalue, .shell = shell}), border);
      EXPECT_TRUE(found.is_sound());
      EXPECT_EQ(found.euler_characteristic, expected.euler_characteristic);
      EXPECT_EQ(found.components, expected.components);
    }
  }
}

TEST_P(ExtractShells, JoinsToTheWeldedMeshAndItsTopology) {
  const DatasetPtr dataset = prepared(GetParam());
  const ForEachTile for_each = [](std::size_t count, const std::function<void(std::size_t)>& body) {
    in_parallel(count, body);
  };
  for (const std::int32_t spacing : {1, 2}) {
    const ShellLevel level = {.isovalue = isovalues_of(*dataset)[0],
                              .finest_spacing = spacing,
                              .shell = quantized_shells(4)};
    const auto shells = extract_shells(*dataset, level, {}, 8);
    const auto meshes = decoded(shells);
    std::vector<TileInCube> tiles;
    std::vector<TileInCube> marched;  // Tiles whose inner edges need not be compared.
    std::vector<OctreeCube> cubes;
    for (std::size_t i = 0; i < meshes.size(); ++i) {
      tiles.push_back({.mesh = &meshes[i], .cube = shells[i].summary.cube});
      marched.push_back(tiles.back());
      marched.back().marched = marched_box(*shells[i].payload);
      cubes.push_back(shells[i].summary.cube);
    }
    EXPECT_TRUE(are_disjoint(cubes));
    // The first border allows no open edge, so that every one counts as a defect.
    DataBorder nowhere = data_border(dataset->info, level.lattice_resolution, 0, spacing);
    nowhere.low = {-1, -1, -1};
    nowhere.high = {1 << 20, 1 << 20, 1 << 20};
    for (const DataBorder& border :
         {nowhere, data_border(dataset->info, level.lattice_resolution, 0, spacing)}) {
      const LatticeMesh expected = weld(meshes, level.lattice_resolution);
      for (const auto& all : {tiles, marched}) {
        const MergedTiles joined = merged_tiles(all, level.lattice_resolution, border, for_each);
        EXPECT_EQ(joined.topology, topology(expected, border));
        EXPECT_EQ(joined.mesh.vertices.size(), expected.vertices.size());
        EXPECT_EQ(sorted_triangles(joined.mesh), sorted_triangles(expected));
      }
    }
    if (meshes.size() < 2) continue;
    // Without the first tile.
    for (const auto& all : {tiles, marched}) {
      const std::vector<TileInCube> without(all.begin() + 1, all.end());
      std::vector<const LatticeMesh*> left;
      for (const TileInCube& tile : without) left.push_back(tile.mesh);
      EXPECT_EQ(merged_tiles(without, level.lattice_resolution, nowhere, for_each).topology,
                topology(weld(left, level.lattice_resolution), nowhere));
    }
  }
}

TEST(ContainsNestedCubes, DetectsCubesInsideOthers) {
  const OctreeCube cube = {.exponent = 4, .x = 1, .y = 2, .z = 3};
  EXPECT_TRUE(are_disjoint(std::vector{cube, OctreeCube{4, 1, 2, 2}, OctreeCube{3, 0, 0, 0}}));
  EXPECT_FALSE(are_disjoint(std::vector{cube, cube}));
  EXPECT_FALSE(are_disjoint(std::vector{cube, cube.child(5)}));
  EXPECT_FALSE(are_disjoint(std::vector{cube.child(5).child(2), cube}));
}

DatasetPtr prepared_noise() {
  return prepared({.name = "noise", .volume = fields::integer_noise({70, 33, 40}, 200, 5)});
}

TEST(ExtractShellTiles, SplitsTilesWithTooManyTriangles) {
  const DatasetPtr dataset = prepared_noise();
  const ShellLevel level = {.isovalue = 100.5};
  constexpr std::uint32_t kMaxTriangles = 12 * 8 * 8 * 8;
  const auto whole = extract_shells(*dataset, level);
  const auto cut = extract_shells(*dataset, level, {}, kShellCells, kMaxTriangles);
  const auto triangles = [](const EncodedTile& tile) { return tile.summary.triangles; };
  EXPECT_GT(std::ranges::max(whole, {}, triangles).summary.triangles, kMaxTriangles);
  EXPECT_LE(std::ranges::max(cut, {}, triangles).summary.triangles, kMaxTriangles);
  EXPECT_EQ(sorted_triangles(weld(decoded(cut), 5)), sorted_triangles(weld(decoded(whole), 5)));
}

TEST(ExtractShellTiles, IsIndependentOfThreadCount) {
  const DatasetPtr dataset = prepared_noise();
  const ShellLevel level = {.isovalue = 77.5, .shell = quantized_shells(2)};
  const auto many = extract_shells(*dataset, level, {}, 16);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const auto alone = extract_shells(*dataset, level, {}, 16);
  ASSERT_EQ(many.size(), alone.size());
  for (std::size_t i = 0; i < many.size(); ++i) {
    EXPECT_EQ(many[i].summary, alone[i].summary);
    EXPECT_EQ(*many[i].payload, *alone[i].payload);
  }
}

TEST(ExtractShellTiles, EndsSoonAfterAStop) {
  const DatasetPtr dataset = prepared_noise();
  std::stop_source stop;
  stop.request_stop();
  EXPECT_THROW((void)extract_shells(*dataset, {.isovalue = 77.5}, stop.get_token()), Cancelled);
}

// Counts the bricks that are read.
class CountedBricks : public BrickSource {
 public:
  explicit CountedBricks(std::shared_ptr<const BrickSource> bricks) : bricks_(std::move(bricks)) {}
  [[nodiscard]] RetainedBytes brick(std::size_t index) const override {
    ++reads;
    return bricks_->brick(index);
  }
  mutable std::atomic<int> reads = 0;

 private:
  std::shared_ptr<const BrickSource> bricks_;
};

TEST(ExtractShellTiles, ReadsOnlyBricksAroundTheSurface) {
  const DatasetPtr dataset =
      prepared({.name = "ball", .volume = fields::ball({100, 100, 100}, 11)});
  PreparedVolume counted = *dataset;
  const auto bricks = std::make_shared<const CountedBricks>(dataset->samples);
  counted.samples = bricks;
  const double isovalue = isovalues_of(*dataset)[1];
  const auto reads_of = [&](std::int32_t spacing) {
    bricks->reads = 0;
    const ShellLevel level = {
        .isovalue = isovalue, .finest_spacing = spacing, .shell = quantized_shells(1)};
    EXPECT_FALSE(extract_shells(counted, level).empty());
    return bricks->reads.load();
  };
  EXPECT_EQ(reads_of(16), 0);
  EXPECT_EQ(reads_of(8), 0);
  EXPECT_GT(reads_of(4), 0);
  EXPECT_LT(reads_of(1), 7 * 7 * 7);
}

TEST(HasShells, MatchesTheLimitsOfTheFormat) {
  DatasetInfo info;
  info.type = SampleType::kU8;
  info.grid_exponent = 9;
  const auto has = [&](ShellLevel level) { return has_shells(info, level); };
  EXPECT_TRUE(has({.isovalue = 80.5}));
  EXPECT_FALSE(has({.isovalue = 1e9}));
  EXPECT_FALSE(has({.isovalue = 80.5, .finest_spacing = 512}));
  const ShellStep lattice_exact = {.values = ShellValues::kLatticeExact};
  EXPECT_TRUE(has({.isovalue = 80.5, .finest_spacing = 8, .shell = lattice_exact}));
  EXPECT_FALSE(has({.isovalue = 80.5, .finest_spacing = 16, .shell = lattice_exact}));
  EXPECT_TRUE(has({.isovalue = 80.5, .finest_spacing = 16, .shell = quantized_shells(1)}));
  EXPECT_TRUE(has({.isovalue = 0, .shell = quantized_shells(1)}));
  EXPECT_FALSE(has({.isovalue = 1e-40, .shell = quantized_shells(1)}));
  info.type = SampleType::kF32;
  EXPECT_FALSE(has({.isovalue = 80.5}));
  EXPECT_TRUE(has({.isovalue = 80.5, .shell = lattice_exact}));
}

}  // namespace
}  // namespace multitetra::testing
