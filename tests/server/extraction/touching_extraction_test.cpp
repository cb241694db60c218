// Labels that are simplified together: they share their borders, and each keeps its guarantees.
#include "server/extraction/touching_extraction.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <vector>

#include "common/mesh/content_digest.hpp"
#include "server/core/simplification/touching_surfaces.hpp"
#include "server/volume/labels/label_map.hpp"
#include "tests/support/fields.hpp"
#include "tests/support/lattice_intersections.hpp"
#include "tests/support/make_dataset.hpp"
#include "tests/support/simplifying.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/volume_in_memory.hpp"

namespace multitetra::testing {
namespace {

using LabelOf = std::function<int(int, int, int)>;

// A ball in three sectors with wavy walls, around which there is background.
int sector_of_a_ball(int x, int y, int z) {
  const double a = x - 15.3 + std::sin(z / 3.0);
  const double b = y - 16.1 + std::cos(z / 2.5);
  if (std::hypot(x - 15.3, y - 16.1, z - 14.6) > 11.2) return 0;
  return a > 0 ? 1 : b > 0 ? 2 : 3;
}

int half_of_a_ball(int x, int y, int z) {
  if (std::hypot(x - 15.3, y - 16.1, z - 14.6) > 11.2) return 0;
  return x + y / 4.0 > 19 ? 1 : 2;
}

std::vector<DatasetPtr> datasets_of(const LabelOf& label) {
  const TemporaryFolder folder;
  const Volume volume = fields::sampled<std::uint8_t>(
      {32, 32, 32}, [&](int x, int y, int z) { return static_cast<std::uint8_t>(label(x, y, z)); });
  const LabelMap map("seg.nrrd", *source_of(volume), folder.path());
  std::vector<DatasetPtr> datasets;
  for (const LabelSummary& found : map.labels()) {
    datasets.push_back(make_dataset(*map.field(found.value),
                                    {.name = "label",
                                     .suggested_isovalues = {kLabelBoundary},
                                     .bin_edges = {kLabelBinEdges.begin(), kLabelBinEdges.end()}}));
  }
  return datasets;
}

IsosurfaceRequest request_for(double error, bool embedded = false) {
  return {
      .isovalue = kLabelBoundary, .error = error, .simplify = true, .intersection_free = embedded};
}

// Turned over, and with the least corner first.
LatticeTriangle from_behind(const LatticeMesh& mesh, const TriangleIndices& t) {
  LatticeTriangle corners = {mesh.vertices[t[0]], mesh.vertices[t[2]], mesh.vertices[t[1]]};
  std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
  return corners;
}
LatticeTriangle from_outside(const LatticeMesh& mesh, const TriangleIndices& t) {
  return from_behind(mesh, {t[0], t[2], t[1]});
}

// The triangles that two meshes have with opposite orientations.
std::size_t common_triangles(const LatticeMesh& a, const LatticeMesh& b) {
  std::set<LatticeTriangle> of_a;
  for (const TriangleIndices& t : a.triangles) of_a.insert(from_outside(a, t));
  return static_cast<std::size_t>(
      std::count_if(b.triangles.begin(), b.triangles.end(),
                    [&](const TriangleIndices& t) { return of_a.contains(from_behind(b, t)); }));
}

TEST(ExtractTouching, KeepsTheTopologyAndTheBoundOfEachSurface) {
  const std::vector<DatasetPtr> datasets = datasets_of(sector_of_a_ball);
  ASSERT_EQ(datasets.size(), 3);
  const TouchingSurfaces full = extract_touching(datasets, request_for(0));
  const Vec3 step = {1.0 / 32, 1.0 / 32, 1.0 / 32};
  for (const double error : {0.25, 0.5, 1.0, 3.0}) {
    const TouchingSurfaces coarse = extract_touching(datasets, request_for(error));
    for (std::size_t i = 0; i < 3; ++i) {
      const LatticeMesh& mesh = coarse.surfaces[i].mesh;
      const LatticeMesh& before = full.surfaces[i].mesh;
      const MeshTopology now = topology(mesh, {});
      EXPECT_TRUE(now.is_sound()) << error;
      EXPECT_EQ(now.euler_characteristic, topology(before, {}).euler_characteristic) << error;
      EXPECT_EQ(now.components, topology(before, {}).components) << error;
      EXPECT_LT(mesh.triangles.size(), before.triangles.size() / 2) << error;
      EXPECT_LE(coarse.surfaces[i].bound, error);
      const auto one = placed(mesh, step);
      const auto other = placed(before, step);
      EXPECT_LE(largest_distance(one, other), coarse.surfaces[i].bound + 1e-9) << error;
      EXPECT_LE(largest_distance(other, one), coarse.surfaces[i].bound + 1e-9) << error;
    }
  }
}

TEST(ExtractTouching, SharesTrianglesOnCommonBorders) {
  const std::vector<DatasetPtr> datasets = datasets_of(sector_of_a_ball);
  for (const double error : {0.0, 0.25, 1.0, 3.0}) {
    const TouchingSurfaces made = extract_touching(datasets, request_for(error));
    const auto common = [&](std::size_t i, std::size_t j) {
      const std::size_t count = common_triangles(made.surfaces[i].mesh, made.surfaces[j].mesh);
      EXPECT_GT(count, 20) << error;
      return count;
    };
    const std::size_t first = common(0, 1);
    const std::size_t second = common(0, 2);
    const std::size_t third = common(1, 2);
    EXPECT_EQ(made.common_triangles,
              (std::vector<std::size_t>{first + second, first + third, second + third}));
  }
}

// What two halves do not share is the surface of the whole: nothing is missing between them, and
// nothing overlaps.
TEST(ExtractTouching, LeavesNoGapBetweenTwoLabels) {
  const std::vector<DatasetPtr> datasets = datasets_of(half_of_a_ball);
  for (const double error : {0.5, 2.0}) {
    const TouchingSurfaces made = extract_touching(datasets, request_for(error));
    const std::vector<LatticeMesh> halves = {made.surfaces[0].mesh, made.surfaces[1].mesh};
    std::vector<LatticeTriangle> outside;
    for (const SurfacePatch& patch : patches_of(halves)) {
      if (patch.second != SurfacePatch::kNone) continue;
      for (const TriangleIndices& t : patch.mesh.triangles) {
        outside.push_back(from_outside(patch.mesh, t));
      }
    }
    const MeshTopology whole = topology(index_triangles(outside, kDefaultLatticeResolution), {});
    EXPECT_TRUE(whole.is_sound()) << error;
    EXPECT_LT(whole.triangles,
              static_cast<std::int64_t>(halves[0].triangles.size() + halves[1].triangles.size()));
  }
}

// Intersections of the union, in which a shared triangle occurs once.
std::size_t intersections(const TouchingSurfaces& made) {
  std::vector<LatticeTriangle> all;
  std::set<LatticeTriangle> known;
  for (const Simplified& surface : made.surfaces) {
    for (const TriangleIndices& t : surface.mesh.triangles) {
      if (known.contains(from_behind(surface.mesh, t))) continue;
      known.insert(from_outside(surface.mesh, t));
      all.push_back(from_outside(surface.mesh, t));
    }
  }
  return lattice_intersections(index_triangles(all, kDefaultLatticeResolution)).pairs;
}

// The full-resolution surfaces intersect in a few tetrahedra with three labels.
TEST(ExtractTouching, AddsNoIntersectionsToEmbeddedSurfaces) {
  const std::vector<DatasetPtr> datasets = datasets_of(half_of_a_ball);
  const std::size_t before = intersections(extract_touching(datasets, request_for(0)));
  for (const double error : {1.0, 4.0}) {
    const TouchingSurfaces made = extract_touching(datasets, request_for(error, true));
    for (const Simplified& surface : made.surfaces) {
      EXPECT_EQ(lattice_intersections(surface.mesh).pairs, 0) << error;
    }
    EXPECT_LE(intersections(made), before) << error;
  }
  EXPECT_GT(intersections(extract_touching(datasets, request_for(4))), before);
}

TEST(ExtractTouching, EqualsSeparateExtractionIfNothingTouches) {
  const LabelOf apart = [](int x, int y, int z) {
    if (std::hypot(x - 8.2, y - 8.1, z - 9.3) < 5) return 1;
    return std::hypot(x - 22.4, y - 22.3, z - 20.2) < 6 ? 2 : 0;
  };
  const std::vector<DatasetPtr> datasets = datasets_of(apart);
  const TouchingSurfaces both = extract_touching(datasets, request_for(0.5));
  for (std::size_t i = 0; i < 2; ++i) {
    const TouchingSurfaces alone = extract_touching({&datasets[i], 1}, request_for(0.5));
    EXPECT_EQ(digest(both.surfaces[i].mesh).hex(), digest(alone.surfaces[0].mesh).hex());
    EXPECT_EQ(both.common_triangles[i], 0);
  }
}

// Times of a series have equal triangles where nothing moves: that is no border between them.
TEST(PatchesOf, KeepsEqualSurfacesApart) {
  const LatticeMesh mesh = {.vertices = {{0, 0, 0}, {8, 0, 0}, {0, 8, 0}, {0, 0, 8}},
                            .triangles = {{0, 2, 1}, {0, 1, 3}, {3, 2, 0}, {2, 3, 1}}};
  const std::vector<SurfacePatch> patches = patches_of(std::vector{mesh, mesh, mesh});
  ASSERT_EQ(patches.size(), 3);
  for (const SurfacePatch& patch : patches) EXPECT_EQ(patch.second, SurfacePatch::kNone);
  for (const Simplified& surface : joined_patches(patches, 3)) {
    EXPECT_EQ(digest(surface.mesh).hex(), digest(mesh).hex());
  }
}

TEST(PatchesOf, SplitsSurfacesWhereTheyTouch) {
  // Two tetrahedra with a common face.
  const std::vector<LatticePoint> points = {{0, 0, 0}, {8, 0, 0}, {0, 8, 0}, {0, 0, 8}, {9, 9, 9}};
  const LatticeMesh one = {.vertices = {points.begin(), points.begin() + 4},
                           .triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
  const LatticeMesh other = {.vertices = {points.begin() + 1, points.end()},
                             .triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
  const std::vector<SurfacePatch> patches = patches_of(std::vector{one, other});
  ASSERT_EQ(patches.size(), 3);
  EXPECT_EQ(patches[0].second, 1);
  EXPECT_EQ(patches[0].mesh.triangles.size(), 1);
  EXPECT_EQ(patches[1].first, 0);
  EXPECT_EQ(patches[1].mesh.triangles.size(), 3);
  EXPECT_EQ(patches[2].first, 1);
  EXPECT_EQ(patches[2].mesh.triangles.size(), 3);
  const std::vector<Simplified> joined = joined_patches(patches, 3);
  ASSERT_EQ(joined.size(), 3);
  EXPECT_EQ(digest(joined[0].mesh).hex(), digest(one).hex());
  EXPECT_EQ(digest(joined[1].mesh).hex(), digest(other).hex());
  EXPECT_TRUE(joined[2].mesh.triangles.empty());
}

}  // namespace
}  // namespace multitetra::testing
