#include "server/core/simplification/simplification.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <vector>

#include "common/base/vec3.hpp"
#include "common/mesh/components.hpp"
#include "common/mesh/content_digest.hpp"
#include "tests/support/simplifying.hpp"

namespace multitetra::testing {
namespace {

double volume_inside(const LatticeMesh& mesh) {
  double volume = 0;
  for (const SurfaceTriangle& t : placed(mesh, {1, 1, 1})) {
    volume += dot(t[0], cross(t[1], t[2])) / 6;
  }
  return volume;
}

// Returns the number of closed components and of those without volume.
std::array<int, 2> closed_and_flat_components(const LatticeMesh& mesh) {
  std::array<int, 2> counts = {0, 0};
  for (const double volume : volumes_of_closed(mesh, components_of(mesh))) {
    if (std::isnan(volume)) continue;
    ++counts[0];
    if (volume == 0) ++counts[1];
  }
  return counts;
}

INSTANTIATE_TEST_SUITE_P(Fields, SimplificationGuarantees, ::testing::ValuesIn(settings()),
                         [](const auto& parameter) { return parameter.param.name; });

TEST_P(SimplificationGuarantees, KeepsTopologyBorderAndVertices) {
  const auto border = border_edges(surface_.mesh);
  std::size_t before = surface_.mesh.triangles.size();
  for (const double max_distance : kDistances) {
    const Simplified small =
        simplified(surface_.mesh, {.lattice_step = step_, .max_distance = max_distance});
    const MeshTopology after = topology(small.mesh, kAnywhere);
    const MeshTopology whole = topology(surface_.mesh, kAnywhere);
    EXPECT_EQ(after.euler_characteristic, whole.euler_characteristic) << max_distance;
    EXPECT_EQ(after.components, whole.components) << max_distance;
    EXPECT_TRUE(after.is_sound()) << max_distance;
    EXPECT_EQ(border_edges(small.mesh), border) << max_distance;
    EXPECT_TRUE(is_subset(small.mesh, surface_.mesh)) << max_distance;
    EXPECT_LT(small.mesh.triangles.size(), before) << max_distance;
  }
}

TEST_P(SimplificationGuarantees, BoundsTheTwoSidedDistance) {
  const auto full = placed(surface_.mesh, step_);
  for (const double max_distance : kDistances) {
    const Simplified small =
        simplified(surface_.mesh, {.lattice_step = step_, .max_distance = max_distance});
    EXPECT_LE(small.bound, max_distance);
    EXPECT_GT(small.bound, 0);
    const auto coarse = placed(small.mesh, step_);
    EXPECT_LE(largest_distance(coarse, full), small.bound) << max_distance;
    EXPECT_LE(largest_distance(full, coarse), small.bound) << max_distance;
  }
}

TEST_P(SimplificationGuarantees, KeepsSeparatelySimplifiedTilesWeldable) {
  const OctreeCube root = root_cube(isosurfaces_.field().grid());
  const ErrorBasedModel model =
      isosurfaces_.model({.isovalue = setting_.isovalue, .threshold = 0.2});
  const auto tiles =
      finished_tiles(surface_in_cube(model, isosurfaces_.field(), root,
                                     {.isovalue = setting_.isovalue, .max_triangles = 700}),
                     root);
  for (const double max_distance : kDistances) {
    std::vector<LatticeMesh> before;
    std::vector<LatticeMesh> after;
    for (const TileMesh& tile : tiles) {
      const Simplified small =
          simplified(tile.mesh, {.lattice_step = step_, .max_distance = max_distance});
      const MeshTopology whole = topology(tile.mesh, kAnywhere);
      const MeshTopology left = topology(small.mesh, kAnywhere);
      EXPECT_EQ(left.euler_characteristic, whole.euler_characteristic);
      EXPECT_EQ(left.components, whole.components);
      EXPECT_EQ(left.border_edges, whole.border_edges);
      before.push_back(tile.mesh);
      after.push_back(small.mesh);
    }
    const auto welded = [](const std::vector<LatticeMesh>& meshes) {
      return topology(weld(meshes, kDefaultLatticeResolution), kAnywhere);
    };
    const MeshTopology whole = welded(before);
    const MeshTopology left = welded(after);
    EXPECT_TRUE(left.is_sound()) << max_distance;
    EXPECT_EQ(left.euler_characteristic, whole.euler_characteristic) << max_distance;
    EXPECT_EQ(left.components, whole.components) << max_distance;
    EXPECT_EQ(left.border_edges, whole.border_edges) << max_distance;
  }
}

TEST_P(SimplificationGuarantees, IsDeterministicAndKeepsTheMeshWithoutABudget) {
  const SimplificationOptions options{.lattice_step = step_, .max_distance = 0.3};
  const Simplified once = simplified(surface_.mesh, options);
  const Simplified again = simplified(surface_.mesh, options);
  EXPECT_EQ(once.mesh.vertices, again.mesh.vertices);
  EXPECT_EQ(once.mesh.triangles, again.mesh.triangles);
  EXPECT_EQ(once.bound, again.bound);
  const Simplified untouched =
      simplified(surface_.mesh, {.lattice_step = step_, .max_distance = 0});
  EXPECT_EQ(digest(untouched.mesh), digest(surface_.mesh));
  EXPECT_EQ(untouched.bound, 0);
}

// The meshes have holes, pinched vertices, edges of three triangles and coincident triangles.
TEST_P(SimplificationGuarantees, KeepsTheTopologyOfNonmanifoldMeshes) {
  std::mt19937_64 random(7);
  for (int round = 0; round < 8; ++round) {
    LatticeMesh broken{.resolution = kDefaultLatticeResolution,
                       .vertices = surface_.mesh.vertices,
                       .triangles = {}};
    const double kept = 0.1 + 0.85 * fields::uniform(random);
    for (TriangleIndices t : surface_.mesh.triangles) {
      if (fields::uniform(random) > kept) continue;
      if (fields::uniform(random) < 0.01) std::swap(t[0], t[1]);
      broken.triangles.push_back(t);
      if (fields::uniform(random) < 0.01) broken.triangles.push_back(t);
    }
    if (broken.triangles.empty()) continue;
    std::vector<LatticeTriangle> soup;
    for (const TriangleIndices& t : broken.triangles) {
      soup.push_back({broken.vertices[t[0]], broken.vertices[t[1]], broken.vertices[t[2]]});
    }
    const LatticeMesh mesh = index_triangles(soup, kDefaultLatticeResolution);
    const Simplified small = simplified(mesh, {.lattice_step = step_, .max_distance = 1e6});
    const MeshTopology before = topology(mesh, kAnywhere);
    const MeshTopology after = topology(small.mesh, kAnywhere);
    EXPECT_EQ(after.euler_characteristic, before.euler_characteristic) << round;
    EXPECT_EQ(after.components, before.components) << round;
    EXPECT_EQ(after.border_edges, before.border_edges) << round;
    EXPECT_EQ(after.nonmanifold_edges, before.nonmanifold_edges) << round;
    EXPECT_EQ(after.degenerate_triangles, 0) << round;
  }
}

TEST(Simplification, KeepsAPositiveVolumeOfClosedComponents) {
  const Volume volume = fields::ball({20, 20, 20}, 7);
  ReferenceIsosurfaces isosurface(volume, std::nullopt, 0);
  const LatticeMesh ball = isosurface({.isovalue = 0, .threshold = 0}).mesh;
  const Simplified small = simplified(ball, {.lattice_step = {1, 1, 1}, .max_distance = 1e9});
  EXPECT_GE(small.mesh.triangles.size(), 4U);
  EXPECT_LT(small.mesh.triangles.size(), 60U);
  EXPECT_GT(volume_inside(small.mesh), 0);
}

TEST_P(SimplificationGuarantees, LeavesNoClosedComponentWithoutVolume) {
  ASSERT_EQ(closed_and_flat_components(surface_.mesh)[1], 0);
  for (const double max_distance : kDistances) {
    const Simplified small =
        simplified(surface_.mesh, {.lattice_step = step_, .max_distance = max_distance});
    const auto [closed, flat] = closed_and_flat_components(small.mesh);
    EXPECT_EQ(flat, 0) << "of " << closed << " at " << max_distance;
  }
}

TEST_P(SimplificationGuarantees, TurnsNoClosedComponentInsideOut) {
  LatticeMesh mesh = surface_.mesh;
  for (const char* const facing : {"as it is", "the other way"}) {  // Cavities become solid.
    for (const double max_distance : kDistances) {
      const Simplified small =
          simplified(mesh, {.lattice_step = step_, .max_distance = max_distance});
      EXPECT_EQ(inverted_vertices(small.mesh, mesh), 0) << max_distance << ", facing " << facing;
    }
    for (TriangleIndices& t : mesh.triangles) std::swap(t[1], t[2]);
  }
}

// Its cheapest tetrahedron is flat.
TEST(Simplification, KeepsTheVolumeOfAFlatOctahedron) {
  const LatticeMesh octahedron{
      .vertices = {{0, 8, 8}, {16, 8, 8}, {8, 0, 8}, {8, 16, 8}, {8, 8, 7}, {8, 8, 9}},
      .triangles = {
          {1, 3, 5}, {3, 0, 5}, {0, 2, 5}, {2, 1, 5}, {3, 1, 4}, {0, 3, 4}, {2, 0, 4}, {1, 2, 4}}};
  for (const double max_distance : {2.0, 1e9}) {
    const Simplified small =
        simplified(octahedron, {.lattice_step = {1, 1, 1}, .max_distance = max_distance});
    EXPECT_LT(small.mesh.triangles.size(), 8U) << max_distance;
    EXPECT_GT(volume_inside(small.mesh), 0) << max_distance;
  }
}

TEST(Simplification, KeepsATetrahedron) {
  const LatticeMesh tetrahedron{.vertices = {{0, 0, 0}, {8, 0, 0}, {0, 8, 0}, {0, 0, 8}},
                                .triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
  const Simplified small =
      simplified(tetrahedron, {.lattice_step = {1, 1, 1}, .max_distance = 1e9});
  EXPECT_EQ(digest(small.mesh), digest(tetrahedron));
}

LatticeMesh plane(std::int32_t side) {
  std::vector<LatticeTriangle> triangles;
  for (std::int32_t y = 0; y < side; ++y) {
    for (std::int32_t x = 0; x < side; ++x) {
      const LatticePoint a = {x, y, 5}, b = {x + 1, y, 5}, c = {x + 1, y + 1, 5}, d = {x, y + 1, 5};
      triangles.push_back({a, b, c});
      triangles.push_back({a, c, d});
    }
  }
  return index_triangles(triangles, kDefaultLatticeResolution);
}

TEST(Simplification, KeepsTheBorderOfAPlane) {
  const LatticeMesh mesh = plane(20);
  const Simplified small = simplified(mesh, {.lattice_step = {1, 1, 1}, .max_distance = 1e-6});
  // A triangulated disk has a triangle per border edge, minus two, plus two per interior vertex.
  EXPECT_LE(small.mesh.triangles.size(), 90U);
  EXPECT_LE(small.bound, 1e-6);
  EXPECT_TRUE(topology(small.mesh, kAnywhere).is_sound());
}

// The quality of a triangle: 1 if equilateral, 0 if degenerate.
double regularity(const SurfaceTriangle& t) {
  const Vec3 a = difference(t[1], t[0]);
  const Vec3 b = difference(t[2], t[0]);
  const Vec3 c = difference(t[2], t[1]);
  return 2 * std::sqrt(3 * squared_length(cross(a, b))) /
         (squared_length(a) + squared_length(b) + squared_length(c));
}

// Long thin triangles cause streaks in the shading.
TEST(Simplification, MakesFewThinTrianglesOnSmoothSurfaces) {
  LatticeMesh waves = plane(60);
  for (LatticePoint& p : waves.vertices) {
    p = {32 * p.x, 32 * p.y,
         static_cast<std::int32_t>(std::lround(90 * std::sin(p.x / 9.0) * std::cos(p.y / 11.0)))};
  }
  const Simplified small = simplified(waves, {.lattice_step = {1, 1, 1}, .max_distance = 3});
  std::size_t thin = 0;
  const auto triangles = placed(small.mesh, {1, 1, 1});
  for (const SurfaceTriangle& t : triangles) thin += regularity(t) < 0.2 ? 1U : 0U;
  EXPECT_LT(triangles.size(), waves.triangles.size() / 5);
  EXPECT_LT(100 * thin, 8 * triangles.size()) << thin << " of " << triangles.size();
}

// The fourth face is in the other piece: collapsing the front would leave two coincident triangles.
TEST(Simplification, KeepsTheVolumeOfATetrahedronInTwoPieces) {
  const LatticeMesh front{.vertices = {{0, 0, 0}, {8, 0, 0}, {0, 8, 0}, {0, 0, 8}},
                          .triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}}};
  const Simplified small = simplified(front, {.lattice_step = {1, 1, 1}, .max_distance = 1e9});
  EXPECT_EQ(digest(small.mesh), digest(front));
}

TEST_P(SimplificationGuarantees, HasAFiniteBoundForAnyValidError) {
  for (const double max_distance : {1e154, 1e300, std::numeric_limits<double>::max()}) {
    const Simplified small =
        simplified(surface_.mesh, {.lattice_step = step_, .max_distance = max_distance});
    EXPECT_TRUE(std::isfinite(small.bound)) << max_distance;
    EXPECT_LT(small.bound, 1e3) << max_distance;
  }
}

// Squares of lengths from 1e-30 to 1e30 exceed the range of single precision.
TEST_P(SimplificationGuarantees, IsIndependentOfTheUnitOfLength) {
  const auto in_unit = [&](double unit) {
    return simplified(surface_.mesh,
                      {.lattice_step = {unit * step_[0], unit * step_[1], unit * step_[2]},
                       .max_distance = unit * 0.25});
  };
  const Simplified expected = in_unit(1);
  for (const double unit : {std::ldexp(1.0, -99), std::ldexp(1.0, 99)}) {
    const Simplified small = in_unit(unit);
    EXPECT_EQ(digest(small.mesh), digest(expected.mesh)) << unit;
    EXPECT_EQ(small.bound, unit * expected.bound) << unit;
  }
}

TEST_P(SimplificationGuarantees, ContinuesWithALargerBudget) {
  SimplifiedPiece piece(surface_.mesh, step_);
  piece.simplify(0.05);
  const std::size_t before = piece.triangles();
  piece.simplify(0.05);
  EXPECT_EQ(piece.triangles(), before) << "nothing is left to try";
  piece.simplify(1e6);
  const std::size_t at_once =
      simplified(surface_.mesh, {.lattice_step = step_, .max_distance = 1e6}).mesh.triangles.size();
  EXPECT_LT(piece.triangles(), before);
  EXPECT_LE(piece.triangles(), at_once + at_once / 4 + 8);
}

TEST_P(SimplificationGuarantees, ChangesNothingIfTheCheckpointThrows) {
  struct Stopped {};
  int calls = 0;
  const auto stop = [&calls] {
    if (++calls == 2) throw Stopped();
  };
  SimplifiedPiece piece(surface_.mesh, step_);
  EXPECT_THROW(piece.simplify(1, stop), Stopped);
  EXPECT_EQ(piece.triangles(), 0);
  EXPECT_TRUE(piece.result().mesh.vertices.empty());
}

TEST(Simplification, KeepsAnEmptyMesh) {
  const Simplified nothing = simplified({}, {.lattice_step = {1, 1, 1}, .max_distance = 1});
  EXPECT_TRUE(nothing.mesh.triangles.empty());
  EXPECT_EQ(nothing.bound, 0);
}

}  // namespace
}  // namespace multitetra::testing
