#include "common/wire/lattice_glb.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "common/mesh/content_digest.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "tests/support/glb_reader.hpp"
#include "tests/support/prepared_fields.hpp"

namespace multitetra::testing {
namespace {

TEST(LatticeGlb, KeepsEveryVertexExactly) {
  const DatasetPtr dataset = prepared({"gyroid", fields::gyroid(65, 0.3, 8)});
  const SurfaceExtractor extractor(dataset);
  for (int i = 0; i < 8; ++i) {
    const OctreeCube cube = OctreeCube{6, 0, 0, 0}.child(i);
    IsosurfaceRequest request{.isovalue = 0.1, .error = 0.2};
    request.cell = OctreeNode{.cube = cube};
    const TiledMesh surface = extractor.extract(final_step(request));
    LatticeMesh mesh = weld(surface.tiles, kDefaultLatticeResolution);
    mesh.normals.assign(mesh.vertices.size(), {0, 0.6F, 0.8F});
    const ReadGlb glb = read_glb(lattice_glb(mesh, cube, {1, 2, 3}, {"liver", 17}));
    EXPECT_EQ(digest(mesh_in(glb)).hex(), digest(mesh).hex());
    EXPECT_TRUE(glb.json["meshes"][0]["primitives"][0]["attributes"].contains("NORMAL"));
    // The matrix scales lattice steps to lengths and turns z up into y up: (0, 0, 32) is at y = 3.
    const auto& matrix = glb.json["nodes"][0]["matrix"];
    EXPECT_EQ(matrix[9], 3.0 / 32);
    EXPECT_EQ(matrix[6], -2.0 / 32);
    EXPECT_EQ(glb.json["nodes"][0]["name"], "liver");
    EXPECT_EQ(glb.json["nodes"][0]["extras"], (nlohmann::json{{"label", 17}}));
  }
}

TEST(LatticeGlb, IsExactForTheLargestGrid) {
  const OctreeCube cube{12, 3, 0, 3};  // In a grid of 2^14 steps with a lattice of 2^20.
  const std::int32_t low = 3 * (1 << 18);
  const LatticeMesh mesh{
      .resolution = 6,
      .vertices = {{low, 0, low}, {1 << 20, 1, low}, {low + 1, 1 << 18, 1 << 20}},
      .triangles = {{0, 1, 2}}};
  EXPECT_EQ(digest(mesh_in(read_glb(lattice_glb(mesh, cube, {1, 1, 1})), 6)).hex(),
            digest(mesh).hex());
}

TEST(LatticeGlb, WritesAnEmptySceneForNoTriangles) {
  const ReadGlb glb = read_glb(lattice_glb({}, {5, 0, 0, 0}, {1, 1, 1}));
  EXPECT_TRUE(glb.binary.empty());
  EXPECT_FALSE(glb.json["scenes"][0].contains("nodes"));
}

}  // namespace
}  // namespace multitetra::testing
