#include "client/library/decoded_tile_cache.hpp"

#include <gtest/gtest.h>

namespace multitetra {
namespace {

ContentDigest digest_of(std::uint64_t number) { return {.high = 7, .low = number}; }

std::shared_ptr<const LatticeMesh> mesh_of(std::size_t triangles) {
  LatticeMesh mesh;
  mesh.triangles.resize(triangles);
  mesh.vertices.resize(triangles + 2);
  return std::make_shared<const LatticeMesh>(std::move(mesh));
}

TEST(DecodedTileCache, EvictsTheLeastRecentlyUsedTile) {
  DecodedTileCache memory({.tiles = 3});
  for (std::uint64_t i = 0; i < 3; ++i) memory.keep(digest_of(i), mesh_of(1));
  memory.use(digest_of(0));
  memory.keep(digest_of(1), mesh_of(1));
  memory.keep(digest_of(3), mesh_of(1));
  EXPECT_FALSE(memory.tiles().contains(digest_of(2)));
  for (const std::uint64_t kept : {0U, 1U, 3U}) {
    EXPECT_TRUE(memory.tiles().contains(digest_of(kept))) << kept;
  }
}

TEST(DecodedTileCache, StaysWithinItsLimits) {
  DecodedTileCache memory({.tiles = 20, .triangles = 100});
  for (std::uint64_t i = 0; i < 500; ++i) {
    memory.keep(digest_of(i * 37 % 101), mesh_of(1 + i * i % 60));
    ASSERT_LE(memory.triangles(), 100U);
    ASSERT_LE(memory.size(), 20U);
    std::uint64_t triangles = 0;
    for (const auto& [digest, mesh] : memory.tiles()) triangles += mesh->triangles.size();
    ASSERT_EQ(memory.triangles(), triangles);
  }
}

TEST(DecodedTileCache, EvictsNothingForATileLargerThanTheLimit) {
  DecodedTileCache memory({.triangles = 100});
  memory.keep(digest_of(0), mesh_of(60));
  memory.keep(digest_of(1), mesh_of(101));
  EXPECT_EQ(memory.size(), 1U);
  EXPECT_TRUE(memory.tiles().contains(digest_of(0)));
}

// Without normals, the server would send the tile again for every request with normals.
TEST(DecodedTileCache, KeepsNormalsOfARepeatedTile) {
  const auto with_normals = [] {
    LatticeMesh mesh = *mesh_of(5);
    mesh.normals.resize(mesh.vertices.size(), {0, 0, 1});
    return std::make_shared<const LatticeMesh>(std::move(mesh));
  }();
  DecodedTileCache memory;
  memory.keep(digest_of(0), mesh_of(5));
  EXPECT_TRUE(memory.digests_to_name(10, /*with_normals=*/true).empty());
  memory.keep(digest_of(0), with_normals);
  EXPECT_EQ(memory.digests_to_name(10, /*with_normals=*/true).size(), 1U);
  memory.keep(digest_of(0), mesh_of(5));
  EXPECT_EQ(memory.tiles().at(digest_of(0)), with_normals);
  EXPECT_EQ(memory.size(), 1U);
  EXPECT_EQ(memory.triangles(), 5U);
}

TEST(DecodedTileCache, ListsTheLargestTilesFirst) {
  DecodedTileCache memory;
  for (std::uint64_t i = 0; i < 10; ++i) memory.keep(digest_of(i), mesh_of(1 + i * 7 % 10));
  EXPECT_EQ(memory.digests_to_name().size(), 10U);
  std::uint64_t named = 0;
  for (const ContentDigest& digest : memory.digests_to_name(3)) {
    named += memory.tiles().at(digest)->triangles.size();
  }
  EXPECT_EQ(named, 10U + 9U + 8U);
}

}  // namespace
}  // namespace multitetra
