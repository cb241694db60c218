// Encodes and decodes the scalars of a tile.
//
// Draco keeps no order of vertices, so scalars have an order of their own: that of the vertices'
// lattice coordinates, by z, then y, then x. So they are a function of a tile's geometry and the
// field, and are sent apart from it: a client that has the tile receives its codes alone.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.hpp"
#include "common/mesh/mesh.hpp"
#include "common/request/scalar_request.hpp"

namespace multitetra {

// The codes of `values`, one a vertex, NaN for none.
[[nodiscard]] std::string encode_scalars(std::span<const LatticePoint> vertices,
                                         std::span<const double> values, const ScalarRange& range);

// The values of the vertices, in their order. kDamagedData unless there is a code for each.
[[nodiscard]] Result<std::vector<float>> decode_scalars(std::string_view codes,
                                                        std::span<const LatticePoint> vertices,
                                                        const ScalarRange& range);

}  // namespace multitetra
