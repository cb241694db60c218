// A tile: the isosurface inside one octree cube, as Draco bytes and back. The only file that sees
// Draco.
//
// Positions are encoded as lattice integers, so what is decoded is bit for bit what was encoded;
// Draco keeps no order of vertices or triangles, so the content is identified by its ContentDigest.
//
// A tile may carry a normal for each vertex, rounded to a grid on the octahedron. Normals are a
// matter of shading: the digest is that of the triangles alone.
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

// The entry of a tile in the manifest.
struct TileSummary {
  OctreeCube cube = {};  // All vertices lie in this closed cube.
  // The digest of its triangles.
  ContentDigest digest = {};
  std::uint32_t triangles = 0;
  std::uint32_t vertices = 0;  // Distinct lattice points.
  std::uint32_t bytes = 0;     // Encoded size.
  double simplification_bound =
      0;  // World units, at most: the distance to the tile before simplification.

  friend bool operator==(const TileSummary&, const TileSummary&) = default;
};

struct EncodedTile {
  TileSummary summary;
  std::shared_ptr<const std::string> payload;  // Draco bytes: made once, sent to many.
};

// No tile has more: it bounds what a decoder allocates. Tiles have 2 000 to 20 000 by intention,
// simplified ones up to 64 000.
inline constexpr std::uint32_t kMaxTileTriangles = std::uint32_t{1} << 20;

// Draco's trade-off between size and time: 0 (smallest) to 9; Draco's 10 switches to a sequential
// method and is not allowed here. Measured on noisy full-resolution surfaces at r = 5: 0 gives 1.12
// bytes a triangle, 5 to 7 give 1.17 at twice the pace, 9 gives 1.20 at the same pace as 5.
inline constexpr int kDefaultEncodingSpeed = 5;
// For a mesh that was simplified, beside which encoding is quick: 5 to 10 % fewer bytes in twice
// the time, and as quick to decode.
inline constexpr int kSimplifiedEncodingSpeed = 1;

// Contents of a tile besides its triangles. A decoded normal is off by at most 1.0, 0.5, 0.25
// degrees with 8, 9, 10 bits, and by a third of that on average. On a noisy head normals add 0.5 to
// 0.6, 0.6 to 0.8, 0.8 to 0.9 bytes a triangle, a tenth to the time of encoding and a third to that
// of decoding.
struct TileNormals {
  std::span<const UnitVector> directions = {};  // One a vertex, each of length 1.
  int bits = 0;  // kMinNormalBits to kMaxNormalBits, or 0: no normals.
};

// Requires 1 to kMaxTileTriangles triangles, none degenerate, coordinates within the lattice, and
// every vertex used and distinct, as in the results of index_triangles. Same mesh, same bytes.
// The mesh's own normals do not matter. Throws std::runtime_error when Draco fails.
[[nodiscard]] EncodedTile encode_tile(const LatticeMesh& mesh, const OctreeCube& cube,
                                      int speed = kDefaultEncodingSpeed,
                                      const TileNormals& normals = {});
// The same where digest(mesh) is known already.
[[nodiscard]] EncodedTile encode_tile(const LatticeMesh& mesh, const OctreeCube& cube,
                                      const ContentDigest& content,
                                      int speed = kDefaultEncodingSpeed,
                                      const TileNormals& normals = {});

// Decodes a tile and checks it against the manifest: counts, digest, vertices inside the cube and
// on the lattice. Never allocates more than in proportion to `promised` and the payload, whatever
// the payload claims: about 100 bytes a triangle. kDamagedData, naming the tile and the first
// difference, otherwise.
//
// The mesh has normals exactly when `normal_bits` is not 0; a payload with normals that were not
// requested, without those that were, or with other bits is damaged, and so is one with several
// normals at a vertex. Requires 0 or kMinNormalBits to kMaxNormalBits.
[[nodiscard]] Result<LatticeMesh> decode_tile(std::string_view payload, const TileSummary& promised,
                                              int lattice_resolution, int normal_bits = 0);

// The normals that decode_tile() returns for a mesh that was encoded with so many bits. Nothing
// for none.
void round_normals(std::vector<UnitVector>& normals, int bits);

// A mesh in float positions as a Draco file (.drc) for other programs: explicit quantization over
// the bounding box with `position_bits` (1 to 30) bits; normals, if there are, with kMaxNormalBits.
[[nodiscard]] std::string encode_draco_file(const PositionedMesh& mesh, int position_bits);

}  // namespace multitetra
