#include "common/mesh/components.hpp"

#include <gtest/gtest.h>

#include "common/mesh/mesh_checks.hpp"
#include "common/mesh/mesh_measures.hpp"

namespace multitetra {
namespace {

// Adds an octahedron; `radius` is in grid steps.
void add_octahedron(std::vector<LatticeTriangle>& triangles, std::int32_t center,
                    std::int32_t radius) {
  const std::int32_t r = radius * 32;
  const std::int32_t c = center * 32;
  const auto at = [c](std::int32_t x, std::int32_t y, std::int32_t z) {
    return LatticePoint{c + x, c + y, c + z};
  };
  for (const std::int32_t x : {-r, r}) {
    for (const std::int32_t y : {-r, r}) {
      for (const std::int32_t z : {-r, r}) {
        const bool is_turned = ((x < 0) != (y < 0)) != (z < 0);
        LatticeTriangle t = {at(x, 0, 0), at(0, y, 0), at(0, 0, z)};
        if (is_turned) std::swap(t[1], t[2]);
        triangles.push_back(t);
      }
    }
  }
}

LatticeMesh dust_and_a_planet() {
  std::vector<LatticeTriangle> triangles;
  for (std::int32_t i = 0; i < 5; ++i) add_octahedron(triangles, 4 + 4 * i, 1);
  add_octahedron(triangles, 100, 20);
  add_octahedron(triangles, 200, 3);
  LatticeMesh mesh = index_triangles(triangles, 5);
  for (const LatticePoint& p : mesh.vertices) {
    mesh.normals.push_back({static_cast<float>(p.x), 0, 0});
  }
  return mesh;
}

TEST(MeshComponents, MatchTheCountOfTheTopology) {
  const LatticeMesh mesh = dust_and_a_planet();
  const MeshComponents components = components_of(mesh);
  EXPECT_EQ(components.diagonals.size(), 7U);
  EXPECT_EQ(topology(mesh, {}).components, 7);
  EXPECT_EQ(components.largest(), 5U);
  EXPECT_NEAR(components.diagonals[5], 40 * std::sqrt(3), 1e-9) << "in samples";
  EXPECT_EQ(components.count_at_least(0), 7U);
  EXPECT_EQ(components.count_at_least(6 * std::sqrt(3) - 1e-9), 2U);
  EXPECT_EQ(components.count_at_least(1000), 0U);
}

TEST(MeshComponents, KeepComponentsOfExactlyTheMinimumDiagonal) {
  // A box of 2 x 3 x 6 samples: its diagonal is exactly 7 if only the root is rounded.
  const std::vector<LatticeTriangle> triangles = {{{{1, 1, 1}, {65, 97, 1}, {65, 1, 193}}}};
  const MeshComponents components = components_of(index_triangles(triangles, 5));
  EXPECT_EQ(components.diagonals.front(), 7.0);
  EXPECT_EQ(components.count_at_least(7), 1U);
}

TEST(MeshComponents, RemoveOnlySmallOnes) {
  const LatticeMesh mesh = dust_and_a_planet();
  const MeshComponents components = components_of(mesh);
  const LatticeMesh all = with_components(mesh, components, 0);
  EXPECT_EQ(all.vertices, mesh.vertices);
  EXPECT_EQ(all.triangles, mesh.triangles);
  const LatticeMesh large = with_components(mesh, components, 5);
  const MeshTopology found = topology(large, {});
  EXPECT_TRUE(found.is_sound());
  EXPECT_EQ(found.components, 2);
  EXPECT_EQ(found.euler_characteristic, 4);
  EXPECT_EQ(large.triangles.size(), 16U);
  ASSERT_EQ(large.normals.size(), large.vertices.size());
  for (std::size_t i = 0; i < large.vertices.size(); ++i) {
    EXPECT_EQ(large.normals[i][0], static_cast<float>(large.vertices[i].x));
  }
  EXPECT_TRUE(with_components(mesh, components, 1000).triangles.empty());
}

// A ball with three cavities, one of them in a grain of dust outside.
TEST(MeshComponents, RemovedWallsFillCavities) {
  std::vector<LatticeTriangle> triangles;
  add_octahedron(triangles, 100, 40);
  add_octahedron(triangles, 200, 4);
  const std::size_t outer = triangles.size();
  for (const std::int32_t center : {95, 105, 200}) add_octahedron(triangles, center, 2);
  for (std::size_t i = outer; i < triangles.size(); ++i) {
    std::swap(triangles[i][1], triangles[i][2]);
  }
  const LatticeMesh mesh = index_triangles(triangles, 5);
  const MeshComponents components = components_of(mesh);
  Affine map;
  map.columns[0][0] = 2;
  const FilledCavities filled = filled_cavities(mesh, components, kLargestAlone, map);
  EXPECT_EQ(filled.count, 2U) << "not that of the dust";
  EXPECT_NEAR(filled.volume, 2 * 2 * 4.0 / 3 * 8, 1e-9);
  EXPECT_EQ(filled_cavities(mesh, components, 7, map).count, 3U) << "the dust stays";
  EXPECT_EQ(filled_cavities(mesh, components, 0, map).count, 0U);
}

TEST(MeshComponents, AreNoneForAnEmptyMesh) {
  const LatticeMesh nothing{};
  EXPECT_TRUE(components_of(nothing).diagonals.empty());
  EXPECT_TRUE(with_components(nothing, components_of(nothing), 1).vertices.empty());
}

}  // namespace
}  // namespace multitetra
