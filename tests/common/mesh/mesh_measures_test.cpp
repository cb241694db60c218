#include "common/mesh/mesh_measures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace multitetra {
namespace {

// An octahedron around `at` with its corners `radius` lattice steps away.
LatticeMesh octahedron(const LatticePoint& at, std::int32_t radius) {
  const auto corner = [&](std::int32_t x, std::int32_t y, std::int32_t z) {
    return LatticePoint{at.x + radius * x, at.y + radius * y, at.z + radius * z};
  };
  return {
      .resolution = 5,
      .vertices = {corner(1, 0, 0), corner(-1, 0, 0), corner(0, 1, 0), corner(0, -1, 0),
                   corner(0, 0, 1), corner(0, 0, -1)},
      .triangles = {
          {0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
}

Affine stretched(double x, double y, double z) {
  return {.columns = {Vec3{x, 0, 0}, Vec3{0, y, 0}, Vec3{0, 0, z}}, .translation = {7, -8, 1e6}};
}

SurfaceMeasures measured(const LatticeMesh& mesh, const Affine& map) {
  return sum_of(measures_of(mesh, components_of(mesh), map));
}

TEST(MeshMeasures, MatchTheFormulaOfAnOctahedron) {
  for (const LatticePoint at : {LatticePoint{64, 64, 64}, LatticePoint{1000000, 900000, 64}}) {
    const SurfaceMeasures whole = measured(octahedron(at, 32), {});
    EXPECT_NEAR(whole.area, 4 * std::sqrt(3.0), 1e-12);
    EXPECT_EQ(whole.volume, 4.0 / 3) << "exact, wherever it is";
  }
  EXPECT_EQ(measured(octahedron({64, 64, 64}, 32), stretched(2, 3, 4)).volume, 32);
  EXPECT_EQ(measured(octahedron({64, 64, 64}, 32), stretched(-2, 3, 4)).volume, 32);
}

// Steiner's formula for the parallel body of an octahedron, whose vertices have less than a ball.
TEST(MeshMeasures, BoundTheVolumeWithinADistance) {
  const SurfaceMeasures whole = measured(octahedron({64, 64, 64}, 32), {});
  const double bend = 12 * std::sqrt(2.0) * std::acos(1.0 / 3);
  EXPECT_NEAR(whole.convex_bend, bend, 1e-9);
  EXPECT_EQ(whole.concave_bend, 0);
  EXPECT_EQ(whole.vertices, 6U);
  for (const double d : {0.01, 0.5, 2.0}) {
    const double parallel =
        d * whole.area + d * d * bend / 2 + 4 * std::numbers::pi / 3 * d * d * d;
    EXPECT_GE(volume_bound(whole, d), parallel);
    EXPECT_LE(volume_bound(whole, d), parallel + 4 * std::numbers::pi * d * d * d);
  }
  // Mirrored and turned inside out, it bends as much.
  EXPECT_NEAR(measured(octahedron({64, 64, 64}, 32), stretched(-1, 1, 1)).convex_bend, bend, 1e-9);
}

// The ball around an inscribed octahedron is farther from it than area times distance says.
TEST(MeshMeasures, BoundTheVolumeOfTheBallAroundASurface) {
  const SurfaceMeasures inscribed = measured(octahedron({64, 64, 64}, 32), {});
  const double distance = 1 - 1 / std::sqrt(3.0);
  const double missing = 4 * std::numbers::pi / 3 - *inscribed.volume;
  EXPECT_GE(volume_bound(inscribed, distance), missing);
}

TEST(MeshMeasures, SubtractTheVolumeOfAHole) {
  LatticeMesh hole = octahedron({64, 64, 64}, 32);
  for (TriangleIndices& t : hole.triangles) std::swap(t[1], t[2]);
  EXPECT_EQ(measured(hole, {}).volume, -4.0 / 3);
  const LatticeMesh outer = octahedron({64, 64, 64}, 64);
  const LatticeMesh* const both[] = {&outer, &hole};
  const LatticeMesh shell = weld(both, 5);
  EXPECT_EQ(components_of(shell).diagonals.size(), 2U);
  EXPECT_NEAR(*measured(shell, {}).volume, 32.0 / 3 - 4.0 / 3, 1e-12);
}

TEST(MeshMeasures, HaveNoVolumeForSurfacesWithABorder) {
  LatticeMesh open = octahedron({64, 64, 64}, 32);
  open.triangles.pop_back();
  const SurfaceMeasures measures = measured(open, {});
  EXPECT_FALSE(measures.volume);
  EXPECT_NEAR(measures.area, 3.5 * std::sqrt(3.0), 1e-12);
  const LatticeMesh closed = octahedron({640, 64, 64}, 32);
  const LatticeMesh* const both[] = {&open, &closed};
  const LatticeMesh two = weld(both, 5);
  const auto each = measures_of(two, components_of(two), {});
  ASSERT_EQ(each.size(), 2U);
  EXPECT_FALSE(each[0].volume);
  EXPECT_EQ(each[1].volume, 4.0 / 3);
}

}  // namespace
}  // namespace multitetra
