#include "common/wire/tile.hpp"

#include <algorithm>
#include <string>

#include <gtest/gtest.h>

#include "common/mesh/mesh_checks.hpp"
#include "common/wire/detail/tile_payload.hpp"
#include "tests/support/surfaces.hpp"

namespace multitetra {
namespace {

// The sorted triangles in orientation order: the mesh independent of its numbering.
std::vector<LatticeTriangle> canonical(const LatticeMesh& mesh) {
  std::vector<LatticeTriangle> triangles;
  for (const TriangleIndices& t : mesh.triangles) {
    LatticeTriangle corners = {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    triangles.push_back(corners);
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

void expect_lossless(const LatticeMesh& mesh, const OctreeCube& cube, int speed) {
  const EncodedTile tile = encode_tile(mesh, cube, speed);
  EXPECT_EQ(tile.summary.bytes, tile.payload->size());
  const Result<LatticeMesh> decoded = decode_tile(*tile.payload, tile.summary, mesh.resolution);
  ASSERT_TRUE(decoded) << decoded.error().text;
  EXPECT_EQ(decoded->resolution, mesh.resolution);
  EXPECT_EQ(decoded->vertices.size(), mesh.vertices.size());
  EXPECT_EQ(canonical(*decoded), canonical(mesh));
}

void expect_damaged(const Result<LatticeMesh>& decoded, const std::string& text) {
  ASSERT_FALSE(decoded);
  EXPECT_EQ(decoded.error().code, ErrorCode::kDamagedData);
  EXPECT_NE(decoded.error().text.find(text), std::string::npos) << decoded.error().text;
  EXPECT_NE(decoded.error().text.find("cube 5:1/0/2"), std::string::npos) << decoded.error().text;
}

EncodedTile small_tile() { return encode_tile(surfaces::torus(5, 12, 8, 0.2, 1), surfaces::kCube); }

TEST(Tile, RoundTripsTrianglesAtEveryResolution) {
  for (const int resolution : {1, 3, 5, 8}) {
    for (const unsigned seed : {1U, 2U, 3U}) {
      expect_lossless(surfaces::torus(resolution, 48, 24, 0.3, seed), surfaces::kCube, 5);
    }
  }
}

TEST(Tile, IsLosslessAtEverySpeed) {
  const LatticeMesh mesh = surfaces::torus(5, 60, 30, 0.3, 4);
  for (int speed = 0; speed < 10; ++speed) expect_lossless(mesh, surfaces::kCube, speed);
}

TEST(Tile, KeepsASingleTriangle) {
  const LatticePoint p = surfaces::low_corner(5);
  const LatticeTriangle triangle = {p, {p.x + 7, p.y, p.z}, {p.x, p.y + 1, p.z + 3}};
  expect_lossless(index_triangles(std::vector{triangle}, 5), surfaces::kCube, 5);
}

TEST(Tile, IsLosslessAtTheEndOfTheLargestLattice) {
  const std::int32_t end = std::int32_t{1} << kMaxLatticeBits;
  const std::vector<LatticeTriangle> triangles = {
      {LatticePoint{end, end, end}, {end - 1, end, end}, {end, end - 1, end}},
      {LatticePoint{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
  expect_lossless(index_triangles(triangles, 8), {.exponent = 12, .x = 0, .y = 0, .z = 0}, 5);
}

TEST(Tile, KeepsNonmanifoldVertices) {
  const LatticeMesh mesh = surfaces::touching_octahedra(5);
  ASSERT_EQ(mesh.vertices.size(), 11U);
  expect_lossless(mesh, surfaces::kCube, 5);
  const EncodedTile tile = encode_tile(mesh, surfaces::kCube);
  EXPECT_EQ(read_claims(*tile.payload)->vertices, 12U) << "Draco did not split: a weak test.";
}

TEST(Tile, KeepsAnEdgeOfFourTriangles) {
  const LatticePoint p = surfaces::center(5);
  std::vector<LatticeTriangle> triangles;
  for (const LatticePoint& tip : {LatticePoint{p.x + 3, p.y, p.z},
                                  {p.x - 3, p.y, p.z},
                                  {p.x, p.y + 3, p.z},
                                  {p.x, p.y - 3, p.z}}) {
    triangles.push_back({p, LatticePoint{p.x, p.y, p.z + 5}, tip});
  }
  expect_lossless(index_triangles(triangles, 5), surfaces::kCube, 5);
}

TEST(Tile, EncodesEqualMeshesEqually) { EXPECT_EQ(*small_tile().payload, *small_tile().payload); }

TEST(Tile, RejectsTilesThatDifferFromTheManifest) {
  const EncodedTile tile = small_tile();
  const auto decode = [&tile](auto change) {
    TileSummary promised = tile.summary;
    change(promised);
    return decode_tile(*tile.payload, promised, 5);
  };
  ASSERT_TRUE(decode([](TileSummary&) {}));
  expect_damaged(decode([](TileSummary& s) { ++s.bytes; }), "bytes");
  expect_damaged(decode([](TileSummary& s) { ++s.triangles; }), "triangles");
  expect_damaged(decode([](TileSummary& s) { --s.triangles; }), "triangles");
  expect_damaged(decode([](TileSummary& s) { ++s.vertices; }), "vertices");
  expect_damaged(decode([](TileSummary& s) { --s.vertices; }), "vertices");
  expect_damaged(decode([](TileSummary& s) { ++s.digest.low; }), "digest");
  expect_damaged(decode([](TileSummary& s) { ++s.digest.high; }), "digest");
  // The resolution seeds the digest; here the cube is checked first.
  expect_damaged(decode_tile(*tile.payload, tile.summary, 4), "outside the tile's cube");
}

TEST(Tile, RejectsVerticesOutsideItsCube) {
  EncodedTile tile = small_tile();
  for (const OctreeCube& cube : {OctreeCube{4, 2, 0, 4}, OctreeCube{5, 0, 0, 2}}) {
    tile.summary.cube = cube;
    const Result<LatticeMesh> decoded = decode_tile(*tile.payload, tile.summary, 5);
    ASSERT_FALSE(decoded);
    EXPECT_NE(decoded.error().text.find("outside the tile's cube"), std::string::npos);
  }
}

TEST(Tile, RejectsOrIgnoresAChangedByte) {
  const EncodedTile tile = encode_tile(surfaces::torus(5, 8, 6, 0.2, 9), surfaces::kCube);
  for (std::size_t at = 0; at < tile.payload->size(); ++at) {
    for (int bit = 0; bit < 8; ++bit) {
      std::string payload = *tile.payload;
      payload[at] = static_cast<char>(payload[at] ^ (1 << bit));
      const Result<LatticeMesh> decoded = decode_tile(payload, tile.summary, 5);
      if (decoded) {
        EXPECT_EQ(digest(*decoded), tile.summary.digest) << "byte " << at << ", bit " << bit;
      } else {
        EXPECT_EQ(decoded.error().code, ErrorCode::kDamagedData);
      }
    }
  }
}

TEST(Tile, RejectsOrKeepsManyTrianglesWithAChangedByte) {
  // Large enough for the valence traversal; changes one bit per byte, to save time.
  const EncodedTile tile = encode_tile(surfaces::torus(5, 36, 16, 0.2, 9), surfaces::kCube);
  ASSERT_EQ((*tile.payload)[11], 2);
  for (std::size_t at = 0; at < tile.payload->size(); ++at) {
    std::string payload = *tile.payload;
    payload[at] = static_cast<char>(payload[at] ^ (1 << at % 8));
    const Result<LatticeMesh> decoded = decode_tile(payload, tile.summary, 5);
    if (decoded) {
      EXPECT_EQ(digest(*decoded), tile.summary.digest) << "byte " << at;
    }
  }
}

TEST(Tile, RejectsTruncation) {
  const EncodedTile tile = small_tile();
  for (std::size_t bytes = 0; bytes < tile.payload->size(); ++bytes) {
    TileSummary promised = tile.summary;
    promised.bytes = static_cast<std::uint32_t>(bytes);
    EXPECT_FALSE(decode_tile(tile.payload->substr(0, bytes), promised, 5)) << bytes << " bytes";
  }
}

// Returns a varint of five bytes.
std::string varint5(std::uint32_t value) {
  std::string bytes;
  for (int i = 0; i < 5; ++i) {
    bytes.push_back(static_cast<char>((value >> (7 * i) & 0x7F) | (i < 4 ? 0x80U : 0U)));
  }
  return bytes;
}

// A payload of `bytes` bytes with consistent counts that declares `triangles` triangles.
std::string boast(std::uint32_t triangles, std::size_t bytes) {
  std::string payload("DRACO\2\2\1\1\0\0\0", 12);
  payload += varint5(triangles / 2) + varint5(triangles) + std::string(1, '\0') +
             varint5(triangles) + varint5(0) + varint5(0);
  payload.resize(bytes, '\1');
  return payload;
}

TEST(Tile, RejectsClaimsOfBillionsOfTrianglesBeforeDecoding) {
  TileSummary promised{
      .cube = surfaces::kCube, .digest = {}, .triangles = 100, .vertices = 50, .bytes = 61};
  for (const std::uint32_t triangles : {0xFFFFFFFFU, 0x80000000U, 0x01000000U, 101U}) {
    ASSERT_EQ(read_claims(boast(triangles, 61))->triangles, triangles);
    expect_damaged(decode_tile(boast(triangles, 61), promised, 5),
                   std::to_string(triangles) + " triangles");
  }
  // Also if the manifest announces as many.
  promised.triangles = 0x80000000U;
  promised.vertices = 0x40000000U;
  expect_damaged(decode_tile(boast(0x80000000U, 61), promised, 5), "at most 1048576");
}

TEST(Tile, RejectsContradictoryCountsBeforeDecoding) {
  const std::string start("DRACO\2\2\1\1\0\0\0", 12);
  const std::string zero(1, '\0');
  const auto claims = [&](std::uint32_t vertices, std::uint32_t triangles, std::uint32_t symbols,
                          std::uint32_t split_symbols) {
    return read_claims(start + varint5(vertices) + varint5(triangles) + zero + varint5(symbols) +
                       varint5(split_symbols));
  };
  EXPECT_TRUE(claims(6, 8, 7, 1));
  EXPECT_FALSE(claims(25, 8, 7, 1)) << "more than three vertices a triangle";
  EXPECT_FALSE(claims(6, 8, 9, 1)) << "more symbols than triangles";
  EXPECT_FALSE(claims(6, 8, 5, 1)) << "fewer symbols than the triangles need";
  EXPECT_FALSE(claims(6, 8, 7, 8)) << "more split symbols than symbols";
}

TEST(Tile, RejectsOtherFormsOfDraco) {
  const EncodedTile tile = small_tile();
  const auto with = [&tile](std::size_t at, char byte) {
    std::string payload = *tile.payload;
    payload[at] = byte;
    return read_claims(payload);
  };
  ASSERT_TRUE(read_claims(*tile.payload));
  EXPECT_FALSE(with(0, 'd')) << "magic";
  EXPECT_FALSE(with(5, 1)) << "major version";
  EXPECT_FALSE(with(6, 1)) << "minor version";
  EXPECT_FALSE(with(7, 0)) << "point cloud";
  EXPECT_FALSE(with(8, 0)) << "sequential method";
  EXPECT_FALSE(with(10, '\x80')) << "metadata";
  EXPECT_FALSE(with(11, 1)) << "predictive traversal";
  // An attribute of another kind stops the decoder before it allocates.
  const std::size_t attribute = tile.payload->find(kTileAttribute);
  ASSERT_NE(attribute, std::string::npos);
  for (std::size_t i = 0; i < kTileAttribute.size(); ++i) {
    std::string payload = *tile.payload;
    ++payload[attribute + i];
    expect_damaged(decode_tile(payload, tile.summary, 5), "Draco cannot decode");
  }
}

}  // namespace
}  // namespace multitetra
