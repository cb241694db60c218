// Encodes and decodes tiles, the isosurface inside one octree cube, with Draco. tile.cpp is the
// only file that includes Draco's encoder.
//
// Positions are encoded as lattice integers, so decoding restores them exactly. Draco does not keep
// the order of vertices and triangles, so the content is identified by its ContentDigest.
//
// A tile may have a normal per vertex, rounded to a grid on the octahedron. Normals only affect
// shading and are not part of the digest.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.hpp"
#include "common/mesh/content_digest.hpp"
#include "common/mesh/mesh.hpp"
#include "common/mesh/octree_cube.hpp"
#include "common/request/isosurface_request.hpp"

namespace multitetra {

// The manifest's entry for a tile.
struct TileSummary {
  // Contains all vertices, faces included.
  OctreeCube cube = {};
  // The digest of the tile's triangles.
  ContentDigest digest = {};
  std::uint32_t triangles = 0;
  std::uint32_t vertices = 0;  // Distinct lattice points.
  std::uint32_t bytes = 0;     // Encoded size.
  // Bounds the distance to the tile before simplification, in world units.
  double simplification_bound = 0;

  friend bool operator==(const TileSummary&, const TileSummary&) = default;
};

struct EncodedTile {
  TileSummary summary;
  // Draco bytes, encoded once and sent to many clients.
  std::shared_ptr<const std::string> payload;
};

// The maximum for any tile, which bounds a decoder's memory. The server aims at 2 000 to 20 000
// triangles, and up to 64 000 in simplified tiles.
inline constexpr std::uint32_t kMaxTileTriangles = std::uint32_t{1} << 20;

// Draco's trade-off between size and time: 0 (smallest) to 9; Draco's 10 is another method and not
// allowed. Measured on noisy full-resolution surfaces at r = 5: 0 gives 1.12 bytes per triangle, 5
// to 7 give 1.17 in half the time, 9 gives 1.20 at the speed of 5.
inline constexpr int kDefaultEncodingSpeed = 5;
// The speed for simplified meshes, whose encoding is quick compared with simplification: 5 to 10 %
// fewer bytes for twice the time, and the same decoding time.
inline constexpr int kSimplifiedEncodingSpeed = 1;

// The normals of a tile. A decoded normal is off by at most 1.0, 0.5, 0.25 degrees with 8, 9, 10
// bits, and by a third of that on average. On a noisy head normals add 0.5 to 0.6, 0.6 to 0.8, 0.8
// to 0.9 bytes per triangle, a tenth to the encoding time and a third to the decoding time.
struct TileNormals {
  std::span<const UnitVector> directions = {};  // One unit vector per vertex.
  int bits = 0;  // kMinNormalBits to kMaxNormalBits, or 0: no normals.
};

// Requires 1 to kMaxTileTriangles triangles, none degenerate, coordinates within the lattice, and
// that every vertex is used and distinct, as in the results of index_triangles(). Deterministic.
// Ignores the mesh's own normals. Throws std::runtime_error if Draco fails.
[[nodiscard]] EncodedTile encode_tile(const LatticeMesh& mesh, const OctreeCube& cube,
                                      int speed = kDefaultEncodingSpeed,
                                      const TileNormals& normals = {});
// Does the same if digest(mesh) is already known.
[[nodiscard]] EncodedTile encode_tile(const LatticeMesh& mesh, const OctreeCube& cube,
                                      const ContentDigest& content,
                                      int speed = kDefaultEncodingSpeed,
                                      const TileNormals& normals = {});

// Decodes a tile and checks it against the manifest: counts, digest, vertices inside the cube and
// on the lattice. Memory is proportional to `promised` and the payload (about 100 bytes per
// triangle), whatever the payload claims. Fails with kDamagedData, naming the tile and the fault.
//
// The mesh has normals if and only if `normal_bits` is not 0. Payloads with unrequested normals,
// without requested ones, with other bits, or with several normals at a vertex are damaged.
// Requires 0 or kMinNormalBits to kMaxNormalBits.
[[nodiscard]] Result<LatticeMesh> decode_tile(std::string_view payload, const TileSummary& promised,
                                              int lattice_resolution, int normal_bits = 0);

// Rounds normals to those that decode_tile() returns after encoding with `bits` bits.
void round_normals(std::vector<UnitVector>& normals, int bits);

// Encodes a mesh, its positions rounded to floats, as a Draco file (.drc) for other programs,
// quantized over its bounding box to `position_bits` (1 to 30) bits, and its normals, if any, to
// kMaxNormalBits.
[[nodiscard]] std::string encode_draco_file(const PositionedMesh& mesh, int position_bits);

}  // namespace multitetra
