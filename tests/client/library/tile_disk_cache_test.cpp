#include "client/library/tile_disk_cache.hpp"

#include <fstream>

#include <gtest/gtest.h>

#include "tests/support/octahedra.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;
using testing::kResolution;

class TileFolderTest : public ::testing::Test {
 protected:
  TileFolderTest() { folder_.keep(tile_.summary, kResolution, 0, *tile_.payload); }

  [[nodiscard]] fs::path file() const {
    return temporary_.path() / "tiles" / (tile_.summary.digest.hex() + ".tile");
  }
  [[nodiscard]] std::string bytes() const {
    std::ifstream stream(file(), std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  void write(const std::string& bytes) const {
    std::ofstream(file(), std::ios::binary | std::ios::trunc) << bytes;
  }
  // Loads the folder as a later run would.
  TileDiskCache::Loaded load(DecodedTileCache& memory, std::uint64_t most_triangles = 1000) const {
    return TileDiskCache(temporary_.path() / "tiles").load(memory, most_triangles);
  }

  EncodedTile tile_ = testing::fine_tiles()[1];
  TemporaryFolder temporary_;
  TileDiskCache folder_{temporary_.path() / "tiles"};
};

TEST_F(TileFolderTest, FindsTilesOfEarlierRuns) {
  DecodedTileCache memory;
  const auto loaded = load(memory);
  EXPECT_EQ(loaded.tiles, 1U);
  EXPECT_EQ(loaded.damaged, 0U);
  const CachedTiles tiles = memory.tiles();
  ASSERT_TRUE(tiles.contains(tile_.summary.digest));
  EXPECT_EQ(digest(*tiles.at(tile_.summary.digest)), tile_.summary.digest);
}

TEST_F(TileFolderTest, MatchesTheDocumentedLayout) {
  EXPECT_TRUE(bytes().starts_with(
      "multitetra tile 1\nlattice 5 cube 4 1 0 0 triangles 6 vertices 6 bytes " +
      std::to_string(tile_.payload->size()) + " normals 0\n"))
      << bytes().substr(0, 100);
  EXPECT_TRUE(bytes().ends_with(*tile_.payload));
}

// Changing an unused byte leaves the tile unchanged.
TEST_F(TileFolderTest, SkipsTilesWithChangedBytes) {
  const std::string whole = bytes();
  int passed_over = 0;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    for (const int change : {0x01, 0x55, 0x80}) {
      std::string damaged = whole;
      damaged[i] = static_cast<char>(damaged[i] ^ change);
      write(damaged);
      DecodedTileCache memory;
      const auto loaded = load(memory);
      ASSERT_EQ(loaded.tiles + loaded.damaged, 1U);
      passed_over += static_cast<int>(loaded.damaged);
      for (const auto& [name, mesh] : memory.tiles()) {
        ASSERT_EQ(name, tile_.summary.digest);
        ASSERT_EQ(digest(*mesh), name);
      }
    }
  }
  EXPECT_GT(passed_over, static_cast<int>(2 * whole.size()));
}

TEST_F(TileFolderTest, SkipsFilesOfWrongLength) {
  const std::string whole = bytes();
  for (std::size_t length = 0; length < whole.size(); ++length) {
    write(whole.substr(0, length));
    DecodedTileCache memory;
    ASSERT_EQ(load(memory).damaged, 1U) << length;
  }
  write(whole + "x");
  DecodedTileCache memory;
  EXPECT_EQ(load(memory).damaged, 1U);
}

TEST_F(TileFolderTest, SkipsNumbersOutOfRange) {
  const std::string whole = bytes();
  const std::string payload = *tile_.payload;
  for (const char* line : {"lattice 0 cube 4 1 0 0 triangles 6 vertices 6",
                           "lattice 9 cube 4 1 0 0 triangles 6 vertices 6",
                           "lattice 5 cube 31 1 0 0 triangles 6 vertices 6",
                           "lattice 5 cube -1 1 0 0 triangles 6 vertices 6",
                           "lattice 5 cube 4 99999 0 0 triangles 6 vertices 6",
                           "lattice 5 cube 4 1 -1 0 triangles 6 vertices 6",
                           "lattice 5 cube 4 1 0 0 triangles 4000000000 vertices 6",
                           "lattice 5 cube 4 1 0 0 triangles 99999999999999999999 vertices 6",
                           "lattice 5 cube 4 1 0 0 triangles 6 vertices 4000000000",
                           "lattice 5 cube 3 1 0 0 triangles 6 vertices 6"}) {
    write("multitetra tile 1\n" + std::string(line) + " bytes " + std::to_string(payload.size()) +
          "\n" + payload);
    DecodedTileCache memory;
    EXPECT_EQ(load(memory).damaged, 1U) << line;
  }
}

TEST_F(TileFolderTest, IgnoresOtherFiles) {
  const fs::path folder = temporary_.path() / "tiles";
  std::ofstream(folder / "notes.txt") << "mine";
  std::ofstream(folder / "short.tile") << "mine";
  fs::create_directory(folder / (std::string(32, '0') + ".tile"));
  DecodedTileCache memory;
  const auto loaded = load(memory);
  EXPECT_EQ(loaded.tiles, 1U);
  EXPECT_EQ(loaded.damaged, 0U);
  EXPECT_TRUE(fs::exists(folder / "notes.txt"));
}

TEST_F(TileFolderTest, LimitsLoadedTriangles) {
  for (const EncodedTile& tile : testing::coarse_tiles()) {
    folder_.keep(tile.summary, kResolution, 0, *tile.payload);
  }
  for (std::uint64_t most = 0; most < 16; ++most) {
    DecodedTileCache memory;
    load(memory, most);
    EXPECT_LE(memory.triangles(), most);
    if (most >= 14) {
      EXPECT_EQ(memory.size(), 3U);
    }
  }
}

}  // namespace
}  // namespace multitetra
