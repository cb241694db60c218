// A surface is identical whether made from extracted meshes or encoded tiles, in any order.
#include "server/service/surface.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>
#include <vector>

#include "common/mesh/mesh_checks.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "server/service/caching_surface_provider.hpp"
#include "tests/support/prepared_fields.hpp"

namespace multitetra {
namespace {

class SurfaceTest : public ::testing::Test {
 protected:
  [[nodiscard]] static ReceivedSurface tiles_of(const EncodedStep& step,
                                                const IsosurfaceRequest& request) {
    ReceivedSurface tiles{.begin = {.request = request, .tiles = {}}, .meshes = step.meshes};
    for (const EncodedTile& tile : step.tiles) {
      tiles.begin.tiles.push_back(tile.summary);
      tiles.payloads.push_back(tile.payload);
      tiles.digest += tile.summary.digest;
    }
    return tiles;
  }
  [[nodiscard]] EncodedStep encoded(const IsosurfaceRequest& request) const {
    return surfaces_.make(final_step(request), {});
  }
  [[nodiscard]] EncodedStep meshes(const IsosurfaceRequest& request) const {
    const CachingSurfaceProvider fresh(extractor_);
    return fresh.make_meshes(final_step(request), {});
  }
  static void expect_equal(const Result<Surface>& a, const Result<Surface>& b) {
    ASSERT_TRUE(a) << a.error().text;
    ASSERT_TRUE(b) << b.error().text;
    EXPECT_GT(a->mesh.triangles.size(), 1000U);
    EXPECT_EQ(a->digest, b->digest);
    EXPECT_EQ(a->mesh.vertices, b->mesh.vertices);
    EXPECT_EQ(a->mesh.triangles, b->mesh.triangles);
    EXPECT_EQ(a->mesh.normals, b->mesh.normals);
  }

  std::shared_ptr<const SurfaceExtractor> extractor_ = std::make_shared<const SurfaceExtractor>(
      testing::prepared({"gyroid", testing::fields::gyroid(40, 0.1, 8)}));
  CachingSurfaceProvider surfaces_{extractor_,
                                   std::make_shared<SurfaceCache>(std::size_t{64} << 20)};
};

TEST_F(SurfaceTest, IsTheSameWithAndWithoutEncoding) {
  for (const bool is_simplified : {false, true}) {
    const IsosurfaceRequest request = {.isovalue = 0.1, .error = 0.25, .simplify = is_simplified};
    const EncodedStep made = meshes(request);
    ASSERT_EQ(made.meshes.size(), made.tiles.size());
    EXPECT_EQ(made.tiles.front().payload, nullptr);
    expect_equal(assembled(tiles_of(made, request), {}),
                 assembled(tiles_of(encoded(request), request), {}));
  }
}

TEST_F(SurfaceTest, HasTheNormalsThatAClientDecodes) {
  for (const int bits : {8, 9, 10}) {
    const IsosurfaceRequest request = {.isovalue = 0.1, .error = 0.5, .normal_bits = bits};
    expect_equal(assembled(tiles_of(meshes(request), request), {}),
                 assembled(tiles_of(encoded(request), request), {}));
  }
}

TEST_F(SurfaceTest, IsIndependentOfTileOrder) {
  const IsosurfaceRequest request = {.isovalue = 0.1, .error = 0.25};
  EncodedStep step = encoded(request);
  const auto surface = assembled(tiles_of(step, request), {});
  std::shuffle(step.tiles.begin(), step.tiles.end(), std::mt19937(1));  // NOLINT: the same always.
  expect_equal(surface, assembled(tiles_of(step, request), {}));
  EXPECT_TRUE(topology(surface->mesh, data_border(surfaces_.info(), request.lattice_resolution, 0))
                  .is_sound());
}

// Their tiles have others in their cubes.
TEST_F(SurfaceTest, OfManyTrianglesIsCountedWhileItIsJoined) {
  const auto noise = std::make_shared<const SurfaceExtractor>(
      testing::prepared({"noise", testing::fields::noise({50, 60, 70}, 3)}));
  const CachingSurfaceProvider surfaces(noise);
  for (const double error : {0.0, 0.1}) {
    const IsosurfaceRequest request = {.isovalue = 0.2, .error = error};
    const EncodedStep step = surfaces.make_meshes(final_step(request), {});
    ASSERT_GT(step.tiles.size(), 8U);
    const auto welded = assembled(tiles_of(step, request), {});
    const auto counted = assembled_and_counted(tiles_of(step, request), surfaces.info(), {});
    ASSERT_TRUE(welded && counted);
    const LatticeMesh sorted = in_canonical_order(welded->mesh);
    const LatticeMesh mesh = in_canonical_order(counted->surface.mesh);
    EXPECT_EQ(mesh.vertices, sorted.vertices);
    EXPECT_EQ(mesh.triangles, sorted.triangles);
    EXPECT_EQ(counted->topology,
              topology(welded->mesh, data_border(surfaces.info(), request.lattice_resolution, 0)));
  }
}

TEST_F(SurfaceTest, IsCountedWhileItIsJoined) {
  for (const IsosurfaceRequest& request :
       {IsosurfaceRequest{.isovalue = 0.1, .error = 0},
        IsosurfaceRequest{.isovalue = -0.2, .error = 0.5},
        IsosurfaceRequest{.isovalue = 0.1, .error = 0.25, .simplify = true},
        IsosurfaceRequest{.isovalue = 0.3, .error = 4, .simplify = true},
        IsosurfaceRequest{.isovalue = 99}}) {
    const auto welded = assembled(tiles_of(meshes(request), request), {});
    ASSERT_TRUE(welded) << welded.error().text;
    const LatticeMesh sorted = in_canonical_order(welded->mesh);
    const MeshTopology expected =
        topology(welded->mesh, data_border(surfaces_.info(), request.lattice_resolution, 0));
    for (const EncodedStep& step : {meshes(request), encoded(request)}) {
      const auto counted = assembled_and_counted(tiles_of(step, request), surfaces_.info(), {});
      ASSERT_TRUE(counted) << counted.error().text;
      const LatticeMesh mesh = in_canonical_order(counted->surface.mesh);
      EXPECT_EQ(mesh.vertices, sorted.vertices);
      EXPECT_EQ(mesh.triangles, sorted.triangles);
      EXPECT_EQ(counted->topology, expected);
      EXPECT_EQ(counted->surface.digest, welded->digest);
    }
  }
}

TEST_F(SurfaceTest, UsesCachedTiles) {
  const IsosurfaceRequest request = {.isovalue = 0.1, .error = 0.25};
  EXPECT_FALSE(surfaces_.make_meshes(final_step(request), {}).meshes.empty());
  const EncodedStep kept = encoded(request);
  const EncodedStep again = surfaces_.make_meshes(final_step(request), {});
  EXPECT_TRUE(again.meshes.empty());
  EXPECT_EQ(again.tiles.front().payload, kept.tiles.front().payload);
}

TEST_F(SurfaceTest, RejectsMissingAndWrongTiles) {
  const IsosurfaceRequest request = {.isovalue = 0.1, .error = 0.25};
  ReceivedSurface missing = tiles_of(encoded(request), request);
  missing.payloads.back() = nullptr;
  EXPECT_EQ(assembled(std::move(missing), {}).error().code, ErrorCode::kDamagedData);
  ReceivedSurface wrong = tiles_of(encoded(request), request);
  wrong.payloads.back() = std::make_shared<const std::string>("nonsense");
  EXPECT_EQ(assembled(std::move(wrong), {}).error().code, ErrorCode::kDamagedData);
  ReceivedSurface other = tiles_of(meshes(request), request);
  other.digest += ContentDigest{1, 2};
  EXPECT_EQ(assembled(std::move(other), {}).error().code, ErrorCode::kDamagedData);
}

}  // namespace
}  // namespace multitetra
