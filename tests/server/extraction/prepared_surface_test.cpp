// Compares the surface of a prepared volume with the reference: the same tetrahedra and triangles,
// however the grid is divided, and all theorems.

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>

#include "server/core/errors/leaves.hpp"
#include "server/core/fine_errors/spectrum_model.hpp"
#include "server/extraction/reference_extractor.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "tests/support/prepared_fields.hpp"
#include "tests/support/tiled_surfaces.hpp"

namespace multitetra::testing {
namespace {

// Sorted triangles, each beginning with its least vertex.
std::vector<LatticeTriangle> canonical(const TileMesh& tile) {
  std::vector<LatticeTriangle> triangles;
  for (const TriangleIndices& t : tile.mesh.triangles) {
    LatticeTriangle triangle = {tile.mesh.vertices[t[0]], tile.mesh.vertices[t[1]],
                                tile.mesh.vertices[t[2]]};
    std::rotate(triangle.begin(), std::min_element(triangle.begin(), triangle.end()),
                triangle.end());
    triangles.push_back(triangle);
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

// Compares the order of vertices and triangles, too.
void expect_equal(const LatticeMesh& a, const LatticeMesh& b) {
  EXPECT_EQ(a.resolution, b.resolution);
  EXPECT_EQ(a.vertices, b.vertices);
  EXPECT_EQ(a.triangles, b.triangles);
}

std::vector<StepRequest> steps_for(const PreparedVolume& dataset) {
  std::vector<StepRequest> steps;
  for (const double isovalue : isovalues_of(dataset)) {
    for (const double error : {0.0, 0.7, 3.0}) {
      for (const ErrorMeasure measure : {ErrorMeasure::kCertified, ErrorMeasure::kPaper}) {
        steps.push_back(
            {.request = {.isovalue = isovalue, .error = error, .error_measure = measure}});
      }
      steps.push_back(
          {.request = {
               .isovalue = isovalue, .error = error, .topology_rule = TopologyRule::kPaper}});
      steps.push_back({.request = {.isovalue = isovalue, .error = error, .topology_tolerance = 2},
                       .finest_spacing = 2});
      steps.push_back({.request = {.isovalue = isovalue, .error = error, .topology_tolerance = 2},
                       .finest_spacing = 4});
      steps.push_back({.request = {.isovalue = isovalue, .error = error, .topology_tolerance = 4},
                       .finest_spacing = 8});
    }
  }
  return steps;
}

class PreparedSurface : public ::testing::TestWithParam<PreparedSetting> {};
INSTANTIATE_TEST_SUITE_P(Fields, PreparedSurface, ::testing::ValuesIn(prepared_settings()),
                         [](const auto& p) { return p.param.name; });
INSTANTIATE_TEST_SUITE_P(FieldsWithoutErrors, PreparedSurface,
                         ::testing::ValuesIn(settings_without_errors()),
                         [](const auto& p) { return p.param.name; });

TEST_P(PreparedSurface, MatchesTheReferenceForTheSameModel) {
  const DatasetPtr dataset = prepared(GetParam());
  const SurfaceExtractor extractor(dataset);
  const ReferenceExtractor reference(*dataset);
  for (const StepRequest& step : steps_for(*dataset)) {
    SCOPED_TRACE(::testing::Message()
                 << "isovalue " << step.request.isovalue << ", error " << step.request.error
                 << ", finest spacing " << step.finest_spacing);
    const TiledMesh fast = extractor.extract(step);
    const TiledMesh slow =
        reference.surface(*reference.spectrum_model(resolved_step(step, dataset->info)),
                          {.isovalue = step.request.isovalue});
    EXPECT_EQ(fast.tetrahedra, slow.tetrahedra);
    EXPECT_EQ(fast.active_tetrahedra, slow.active_tetrahedra);
    ASSERT_EQ(fast.tiles.size(), slow.tiles.size());
    for (std::size_t i = 0; i < fast.tiles.size(); ++i) {
      EXPECT_EQ(fast.tiles[i].cube, slow.tiles[i].cube);
      EXPECT_EQ(canonical(fast.tiles[i]), canonical(slow.tiles[i]));
    }
  }
}

TEST_P(PreparedSurface, IsIndependentOfTheExtractionCubes) {
  const DatasetPtr dataset = prepared(GetParam());
  const OctreeCube root = root_cube(grid_of(dataset->info));
  for (const double isovalue : isovalues_of(*dataset)) {
    const PreparedModel model(*dataset, {.isovalue = isovalue},
                              {.thresholds = ThresholdMap::everywhere(0.5)});
    const SurfaceOptions options{.isovalue = isovalue, .max_triangles = 300};
    CubeMemory memory;
    std::vector<CubeSurface> children(8);
    for (int i = 0; i < 8; ++i) {
      if (root.exponent > kSpectrumExponent + 1 && is_refined(model, root.child(i))) {
        children[static_cast<std::size_t>(i)] =
            surface_in_cube(model, root.child(i), options, memory);
      }
    }
    CubeSurface whole = surface_in_cube(model, root, options, memory);
    if (root.exponent == kSpectrumExponent + 1) continue;
    CubeSurface joined = join_children(model, root, std::move(children), options);
    EXPECT_EQ(joined.tetrahedra, whole.tetrahedra);
    const std::vector<TileMesh> tiles = finished_tiles(std::move(joined), root);
    const std::vector<TileMesh> expected = finished_tiles(std::move(whole), root);
    ASSERT_EQ(tiles.size(), expected.size());
    for (std::size_t i = 0; i < tiles.size(); ++i) {
      EXPECT_EQ(tiles[i].cube, expected[i].cube);
      expect_equal(tiles[i].mesh, expected[i].mesh);
    }
  }
}

TEST_P(PreparedSurface, HasNoCrackAndTheTopologyOfTheFullSurfaceAtEveryThreshold) {
  const DatasetPtr dataset = prepared(GetParam());
  const DatasetInfo& info = dataset->info;
  const bool has_mask = info.void_samples > 0;
  const SurfaceExtractor extractor(dataset);
  const ReferenceExtractor reference(*dataset);
  const DataBorder border = data_border(info, kDefaultLatticeResolution, 0);
  for (const double isovalue : isovalues_of(*dataset)) {
    const MeshTopology full = topology(
        mesh_of(reference.surface(UniformModel(grid_of(info), 1000), {.isovalue = isovalue})),
        border);
    std::uint64_t last = UINT64_MAX;
    for (const double error : {0.0, 0.25, 1.0, 4.0, 1e9}) {
      SCOPED_TRACE(::testing::Message() << "isovalue " << isovalue << ", error " << error);
      const TiledMesh surface =
          extractor.extract({.request = {.isovalue = isovalue, .error = error}});
      const MeshTopology found = topology(mesh_of(surface), border);
      EXPECT_EQ(found.euler_characteristic, full.euler_characteristic);
      EXPECT_EQ(found.components, full.components);
      EXPECT_EQ(found.nonmanifold_edges, 0);
      if (!has_mask) {
        EXPECT_EQ(found.open_edges, 0);
      }
      EXPECT_LE(surface.tetrahedra, last);
      last = surface.tetrahedra;
    }
  }
}

TEST_P(PreparedSurface, HasOnlySlightlyMoreTetrahedraThanTheExactModel) {
  const DatasetPtr dataset = prepared(GetParam());
  const SurfaceExtractor extractor(dataset);
  const ReferenceExtractor reference(*dataset);
  std::uint64_t with_spectrum = 0;
  std::uint64_t exact = 0;
  for (const double isovalue : isovalues_of(*dataset)) {
    for (const double error : {0.0, 0.5, 2.0}) {
      const StepRequest step{.request = {.isovalue = isovalue, .error = error}};
      const std::uint64_t more = extractor.extract(step).tetrahedra;
      const std::uint64_t fewer = reference.extract(resolved_step(step, dataset->info)).tetrahedra;
      EXPECT_GE(more, fewer) << isovalue << " " << error;
      with_spectrum += more;
      exact += fewer;
    }
  }
  // Few points of these small fields have a spacing of 8 or more, but all of them count.
  const double most = GetParam().samples_only ? 1.1 : 1.05;
  EXPECT_LE(static_cast<double>(with_spectrum), most * static_cast<double>(exact) + 500);
}

// Counts how often each brick is read.
class CountedBricks : public BrickSource {
 public:
  CountedBricks(std::shared_ptr<const BrickSource> source, std::size_t size)
      : source_(std::move(source)), times_read_(size) {}
  [[nodiscard]] RetainedBytes brick(std::size_t index) const override {
    ++times_read_[index];
    return source_->brick(index);
  }
  [[nodiscard]] std::size_t read() const {
    return times_read_.size() -
           static_cast<std::size_t>(std::count(times_read_.begin(), times_read_.end(), 0));
  }
  [[nodiscard]] int most_reads() const {
    return *std::max_element(times_read_.begin(), times_read_.end());
  }

 private:
  std::shared_ptr<const BrickSource> source_;
  mutable std::vector<std::atomic<int>> times_read_;
};

// A dataset whose reads are counted.
struct Counted {
  explicit Counted(const PreparedSetting& setting)
      : dataset(std::make_shared<PreparedVolume>(*prepared(setting))),
        bricks(std::make_shared<CountedBricks>(dataset->samples,
                                               BrickLayout(dataset->info.dims).size())) {
    dataset->samples = bricks;
  }
  std::shared_ptr<PreparedVolume> dataset;
  std::shared_ptr<CountedBricks> bricks;
};

TEST(PreparedSurfaces, ReadNoSamplesForPreviewsAtTheSpectrumsSpacing) {
  const Counted counted({"gyroid", fields::gyroid(65, 0.2, 1)});
  const SurfaceExtractor extractor(counted.dataset);
  const TiledMesh preview = extractor.extract(
      {.request = {.isovalue = 0.1, .error = 2, .topology_tolerance = 8}, .finest_spacing = 8});
  EXPECT_GT(preview.active_tetrahedra, 100U);
  EXPECT_EQ(counted.bricks->read(), 0U);
  (void)extractor.extract({.request = {.isovalue = 0.1, .error = 0.5}});
  EXPECT_GT(counted.bricks->read(), 0U);
}

TEST(PreparedSurfaces, ReadOnlyTheBricksNearTheSurface) {
  const Counted counted(
      {"small_ball", fields::sampled<float>({97, 97, 97}, [](int x, int y, int z) {
         return 6 - std::hypot(x - 20, y - 20, z - 20);
       })});
  (void)SurfaceExtractor(counted.dataset).extract({.request = {.isovalue = 0, .error = 0}});
  EXPECT_GT(counted.bricks->read(), 0U);
  EXPECT_LE(counted.bricks->read(), 64U);  // Of 343 bricks.
}

TEST(PreparedSurfaces, ReadEveryBrickOnceInACube) {
  // With a margin, cells of eight samples extend across bricks.
  for (const std::int32_t margin : {0, 3}) {
    const Counted counted({"noise", fields::noise({50, 41, 37}, 6), std::nullopt, margin});
    const PreparedModel model(*counted.dataset, {.isovalue = 0.5},
                              {.thresholds = ThresholdMap::everywhere(0)});
    CubeMemory memory;
    const CubeSurface surface = surface_in_cube(model, root_cube(grid_of(counted.dataset->info)),
                                                {.isovalue = 0.5}, memory);
    EXPECT_GT(surface.active_tetrahedra, 100U);
    EXPECT_EQ(counted.bricks->read(), 4U * 3U * 3U);
    EXPECT_EQ(counted.bricks->most_reads(), 1);
  }
}

TEST(PreparedSurfaces, MatchTheReferenceOnTinyGrids) {
  for (const std::array<std::int32_t, 3> dims :
       {std::array{2, 2, 2}, std::array{3, 5, 4}, std::array{9, 9, 9}}) {
    const DatasetPtr dataset = prepared({"tiny", fields::noise(dims, 5)});
    const StepRequest step{.request = {.isovalue = 0.5, .error = 0.3}};
    const TiledMesh surface = SurfaceExtractor(dataset).extract(step);
    EXPECT_EQ(surface.tetrahedra,
              ReferenceExtractor(*dataset).extract(resolved_step(step, dataset->info)).tetrahedra);
    EXPECT_GT(surface.active_tetrahedra, 0U);
  }
}

}  // namespace
}  // namespace multitetra::testing
