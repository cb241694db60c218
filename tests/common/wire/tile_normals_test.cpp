// Tiles with normals: their transmission, accuracy, and rejection.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "common/wire/detail/tile_payload.hpp"
#include "common/wire/tile.hpp"
#include "tests/support/surfaces.hpp"

namespace multitetra {
namespace {

constexpr int kSpeed = kDefaultEncodingSpeed;

std::vector<UnitVector> random_directions(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> coordinate;
  std::vector<UnitVector> directions = {{0, 0, 1}, {0, 0, -1}, {-1, 0, 0}, {0, -1, 0}};
  while (directions.size() < count) {
    const double x = coordinate(random);
    const double y = coordinate(random);
    const double z = coordinate(random);
    const double length = std::hypot(x, y, z);
    directions.push_back({static_cast<float>(x / length), static_cast<float>(y / length),
                          static_cast<float>(z / length)});
  }
  directions.resize(count);
  return directions;
}

double degrees_between(const UnitVector& a, const UnitVector& b) {
  double square = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    square += std::pow(static_cast<double>(a[axis]) - static_cast<double>(b[axis]), 2);
  }
  return 2 * std::asin(std::min(1.0, std::sqrt(square) / 2)) * 180 / std::numbers::pi;
}

// A noisy torus with holes, and a small octahedron next to it.
LatticeMesh torn_surface() {
  const LatticeMesh torus = surfaces::torus(5, 60, 30, 0.2, 3);
  std::vector<LatticeTriangle> triangles;
  for (std::size_t i = 0; i < torus.triangles.size(); ++i) {
    const TriangleIndices& t = torus.triangles[i];
    if (i % 40 > 5) {
      triangles.push_back({torus.vertices[t[0]], torus.vertices[t[1]], torus.vertices[t[2]]});
    }
  }
  for (const LatticeTriangle& t : surfaces::octahedron(surfaces::center(5), 9)) {
    triangles.push_back(t);
  }
  return index_triangles(triangles, 5);
}

void expect_refused(const Result<LatticeMesh>& decoded, const std::string& text) {
  ASSERT_FALSE(decoded);
  EXPECT_EQ(decoded.error().code, ErrorCode::kDamagedData);
  EXPECT_NE(decoded.error().text.find(text), std::string::npos) << decoded.error().text;
}

TEST(TileNormals, RoundTripWithinTheRoundingOfTheirBits) {
  const std::map<int, double> degrees = {{8, 1.0}, {9, 0.5}, {10, 0.25}};
  for (const LatticeMesh& mesh :
       {torn_surface(), surfaces::torus(5, 20, 10, 0.3, 1), surfaces::touching_octahedra(5)}) {
    const auto directions = random_directions(mesh.vertices.size(), 7);
    std::map<LatticePoint, UnitVector> sent;
    for (std::size_t i = 0; i < directions.size(); ++i) sent[mesh.vertices[i]] = directions[i];
    for (const auto& [bits, bound] : degrees) {
      for (const int speed : {0, 3, 5, 9}) {
        const EncodedTile tile = encode_tile(mesh, surfaces::kCube, speed, {directions, bits});
        const Result<LatticeMesh> decoded = decode_tile(*tile.payload, tile.summary, 5, bits);
        ASSERT_TRUE(decoded) << decoded.error().text;
        ASSERT_EQ(decoded->normals.size(), mesh.vertices.size());
        double largest = 0;
        for (std::size_t i = 0; i < decoded->normals.size(); ++i) {
          largest = std::max(largest,
                             degrees_between(decoded->normals[i], sent.at(decoded->vertices[i])));
        }
        EXPECT_LT(largest, bound) << bits << " bits, speed " << speed;
      }
    }
  }
}

TEST(TileNormals, ChangeNothingButTheBytes) {
  const LatticeMesh mesh = torn_surface();
  const EncodedTile plain = encode_tile(mesh, surfaces::kCube);
  const EncodedTile shaded =
      encode_tile(mesh, surfaces::kCube, kSpeed, {random_directions(mesh.vertices.size(), 1), 8});
  TileSummary summary = shaded.summary;
  summary.bytes = plain.summary.bytes;
  EXPECT_EQ(summary, plain.summary);
  EXPECT_TRUE(decode_tile(*plain.payload, plain.summary, 5)->normals.empty());
  EXPECT_EQ(digest(*decode_tile(*shaded.payload, shaded.summary, 5, 8)), plain.summary.digest);
}

TEST(TileNormals, RejectNormalsOtherThanRequested) {
  const LatticeMesh mesh = torn_surface();
  const auto directions = random_directions(mesh.vertices.size(), 1);
  const EncodedTile plain = encode_tile(mesh, surfaces::kCube);
  expect_refused(decode_tile(*plain.payload, plain.summary, 5, 8), "Draco cannot decode");
  for (const int bits : {8, 9, 10}) {
    const EncodedTile tile = encode_tile(mesh, surfaces::kCube, kSpeed, {directions, bits});
    EXPECT_NE(tile.payload->find(kTileAttributesWithNormals), std::string::npos);
    EXPECT_EQ(tile.payload->back(), bits);
    expect_refused(decode_tile(*tile.payload, tile.summary, 5), "Draco cannot decode");
    for (const int promised : {8, 9, 10}) {
      if (promised == bits) continue;
      expect_refused(decode_tile(*tile.payload, tile.summary, 5, promised),
                     std::to_string(promised) + " bits");
    }
  }
}

TEST(TileNormals, RejectOtherForms) {
  const LatticeMesh mesh = surfaces::torus(5, 12, 8, 0.2, 1);
  const EncodedTile tile =
      encode_tile(mesh, surfaces::kCube, kSpeed, {random_directions(mesh.vertices.size(), 1), 8});
  const std::size_t attributes = tile.payload->find(kTileAttributesWithNormals);
  ASSERT_NE(attributes, std::string::npos);
  for (std::size_t i = 0; i < kTileAttributesWithNormals.size(); ++i) {
    std::string payload = *tile.payload;
    ++payload[attributes + i];
    expect_refused(decode_tile(payload, tile.summary, 5, 8), "Draco cannot decode");
  }
}

TEST(TileNormals, RejectDifferentNormalsAtOneVertex) {
  // Two touching octahedra, indexed separately: their common vertex occurs twice.
  const LatticePoint middle = surfaces::center(5);
  LatticeMesh twice =
      index_triangles(surfaces::octahedron({middle.x - 4, middle.y, middle.z}, 4), 5);
  const LatticeMesh other =
      index_triangles(surfaces::octahedron({middle.x + 4, middle.y, middle.z}, 4), 5);
  for (const TriangleIndices& t : other.triangles) {
    twice.triangles.push_back({t[0] + 6, t[1] + 6, t[2] + 6});
  }
  twice.vertices.insert(twice.vertices.end(), other.vertices.begin(), other.vertices.end());
  const auto decoded = [&](const std::vector<UnitVector>& directions) {
    EncodedTile tile = encode_tile(twice, surfaces::kCube, kSpeed, {directions, 8});
    tile.summary.vertices = 11;
    return decode_tile(*tile.payload, tile.summary, 5, 8);
  };
  EXPECT_TRUE(decoded(std::vector<UnitVector>(12, {0, 1, 0})));
  expect_refused(decoded(random_directions(12, 2)), "several normals");
}

TEST(TileNormals, RejectOrDecodeUnitVectorsAfterAChangedByte) {
  const LatticeMesh mesh = surfaces::torus(5, 8, 6, 0.2, 9);
  const EncodedTile tile =
      encode_tile(mesh, surfaces::kCube, kSpeed, {random_directions(mesh.vertices.size(), 4), 9});
  int decodable = 0;
  for (std::size_t at = 0; at < tile.payload->size(); ++at) {
    for (int bit = 0; bit < 8; ++bit) {
      std::string payload = *tile.payload;
      payload[at] = static_cast<char>(payload[at] ^ (1 << bit));
      const Result<LatticeMesh> decoded = decode_tile(payload, tile.summary, 5, 9);
      if (!decoded) {
        EXPECT_EQ(decoded.error().code, ErrorCode::kDamagedData);
        continue;
      }
      ++decodable;
      EXPECT_EQ(digest(*decoded), tile.summary.digest) << "byte " << at << ", bit " << bit;
      EXPECT_EQ(decoded->normals.size(), mesh.vertices.size());
      EXPECT_TRUE(std::all_of(decoded->normals.begin(), decoded->normals.end(), is_unit));
    }
  }
  EXPECT_GT(decodable, 0) << "No change of a normal alone: a weak test.";
}

TEST(TileNormals, RejectTruncation) {
  const LatticeMesh mesh = surfaces::torus(5, 12, 8, 0.2, 1);
  const EncodedTile tile =
      encode_tile(mesh, surfaces::kCube, kSpeed, {random_directions(mesh.vertices.size(), 4), 8});
  for (std::size_t bytes = 0; bytes < tile.payload->size(); ++bytes) {
    TileSummary promised = tile.summary;
    promised.bytes = static_cast<std::uint32_t>(bytes);
    EXPECT_FALSE(decode_tile(tile.payload->substr(0, bytes), promised, 5, 8)) << bytes;
  }
}

TEST(WeldedNormals, AreOnePerVertexIfAllPiecesHaveThem) {
  std::vector<LatticeMesh> pieces(2);
  const LatticePoint middle = surfaces::center(5);
  pieces[0] = index_triangles(surfaces::octahedron({middle.x - 4, middle.y, middle.z}, 4), 5);
  pieces[1] = index_triangles(surfaces::octahedron({middle.x + 4, middle.y, middle.z}, 4), 5);
  const std::vector<const LatticeMesh*> pointers = {&pieces[0], &pieces[1]};
  pieces[0].normals = random_directions(6, 1);
  EXPECT_TRUE(weld(pointers, 5).normals.empty());
  pieces[1].normals = random_directions(6, 2);
  const LatticeMesh whole = weld(pointers, 5);
  ASSERT_EQ(whole.vertices.size(), 11U);
  ASSERT_EQ(whole.normals.size(), 11U);
  for (const LatticeMesh* piece : pointers) {
    for (std::size_t i = 0; i < 6; ++i) {
      if (piece == pointers[1] && piece->vertices[i] == middle)
        continue;  // The first piece determines the normal.
      const auto at = std::find(whole.vertices.begin(), whole.vertices.end(), piece->vertices[i]);
      EXPECT_EQ(whole.normals[static_cast<std::size_t>(at - whole.vertices.begin())],
                piece->normals[i]);
    }
  }
  EXPECT_EQ(positioned(whole, Affine{}).normals, whole.normals);
}

}  // namespace
}  // namespace multitetra
