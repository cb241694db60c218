// Reads the counts a tile's payload claims before it is decoded.
//
// A Draco bitstream of a few bytes can claim billions of triangles, for which the decoder allocates
// memory. So this parses the start of the only form our encoder writes, without allocating, and
// rejects other methods and versions, metadata and further attributes.
//
//   "DRACO"  2 2  1 1  0 0       magic, version 2.2, triangle mesh, edgebreaker, no flags
//   0 or 2                       standard or valence traversal
//   vertices, triangles          varints
//   0                            attributes with a connectivity of their own
//   symbols, split symbols       varints; a symbol for each triangle except at most every fourth
//   ...                          the traversal, in memory in proportion to the triangles
//   1, 3 bytes                   one attribute decoder, and how it walks the mesh
//   1  0 5 3 0  0  1             one attribute: POSITION, INT32, 3 components, not normalized;
//                                its id; coded as integers
//   ...                          prediction and residuals
//
// Tiles with normals have two attributes, traversed together:
//
//   2  0 5 3 0  0                POSITION as above,
//      1 9 3 0  1  1 3           NORMAL, FLOAT32, 3 components, not normalized; its id; how the two
//                                are coded: as integers and as octahedral integers
//   ...                          prediction and residuals of both
//   bits                         of an octahedral coordinate
#pragma once

#include <cstdint>
#include <string_view>

#include "common/base/result.hpp"

namespace multitetra {

struct TilePayloadClaims {
  std::uint32_t triangles = 0;
  // The number after Draco split non-manifold vertices: at least that of our mesh.
  std::uint32_t vertices = 0;
};

// Fails with kDamagedData, naming the position and the fault, if the bytes do not have the form
// above or their numbers contradict each other.
[[nodiscard]] Result<TilePayloadClaims> read_claims(std::string_view payload);

// The bytes from the number of attributes up to the prediction of an attribute.
inline constexpr std::string_view kTileAttribute("\1\0\5\3\0\0\1", 7);
inline constexpr std::string_view kTileAttributesWithNormals("\2\0\5\3\0\0\1\x9\3\0\1\1\3", 13);

}  // namespace multitetra
