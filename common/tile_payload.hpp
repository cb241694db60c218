// What a tile's payload claims, read before anything is decoded.
//
// A Draco bitstream of a few bytes can claim billions of triangles, and the decoder believes it and
// allocates. So the one form that our encoder writes is walked here up to its geometry, without
// allocating, and everything else is refused: other methods and versions, metadata, further
// attributes. Each triangle takes at least 3/4 of a bit in that form, so what passes needs memory
// in proportion to its own length.
//
//   "DRACO"  2 2  1 1  0 0       magic, version 2.2, triangle mesh, edgebreaker, no flags
//   0                            standard traversal
//   vertices, triangles          varints
//   0                            attributes with a connectivity of their own
//   symbols, split symbols       varints
//   splits                       count, two varints each, then a bit each
//   traversal                    length, one to three bits for each symbol
//   start faces                  probability, length, entropy-coded bits
//   1, 3 bytes                   one attribute decoder and how it walks the mesh
//   1, 0 5 3, 2 bytes, 1         one attribute: POSITION, INT32, 3 components; coded as integers
//   ...                          prediction and residuals
#pragma once

#include <cstdint>
#include <string_view>

#include "common/result.hpp"

namespace multitetra {

struct TilePayloadClaims {
  std::uint32_t triangles = 0;
  std::uint32_t vertices = 0;  // After Draco's splitting of non-manifold ones: not fewer than ours.
};

// kDamagedData, saying what stands where, when the bytes are not of the form above or claim more
// triangles than they can hold.
[[nodiscard]] Result<TilePayloadClaims> read_claims(std::string_view payload);

}  // namespace multitetra
