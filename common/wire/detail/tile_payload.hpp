// Reads the counts that a tile's payload claims before anything is decoded.
//
// A Draco bitstream of a few bytes can claim billions of triangles, and the decoder allocates
// memory for them. So the start of the one form that our encoder writes is parsed here, without
// allocating; other methods and versions, metadata and further attributes are refused.
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
// In a tile with normals there are two attributes, walked together:
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
  std::uint32_t vertices = 0;  // After Draco's splitting of non-manifold ones: not fewer than ours.
};

// kDamagedData, saying what stands where, when the bytes do not start in the form above or their
// numbers contradict each other.
[[nodiscard]] Result<TilePayloadClaims> read_claims(std::string_view payload);

// The bytes before an attribute's prediction, from the number of attributes on.
inline constexpr std::string_view kTileAttribute("\1\0\5\3\0\0\1", 7);
inline constexpr std::string_view kTileAttributesWithNormals("\2\0\5\3\0\0\1\x9\3\0\1\1\3", 13);

}  // namespace multitetra
