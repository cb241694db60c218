// Encodes and decodes the scalars of a tile.
//
// Since Draco does not keep the order of vertices, scalars are ordered by the vertices' lattice
// coordinates: by z, then y, then x. So they depend only on a tile's geometry and the field, and
// are sent separately: a client that has the tile receives only its codes.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.hpp"
#include "common/mesh/mesh.hpp"
#include "common/request/scalar_request.hpp"

namespace multitetra {

// Encodes `values`, one per vertex, NaN for none.
[[nodiscard]] std::string encode_scalars(std::span<const LatticePoint> vertices,
                                         std::span<const double> values, const ScalarRange& range);

// Returns the values in the vertices' order. Fails with kDamagedData unless each vertex has a code.
[[nodiscard]] Result<std::vector<float>> decode_scalars(std::string_view codes,
                                                        std::span<const LatticePoint> vertices,
                                                        const ScalarRange& range);

}  // namespace multitetra
