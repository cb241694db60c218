// The tetrahedra of a model as a file for volume rendering in ParaView: VTK XML UnstructuredGrid
// (.vtu).
#pragma once

#include <string>

#include "common/base/affine.hpp"
#include "server/core/errors/error_based_model.hpp"
#include "server/core/framework/field.hpp"

namespace multitetra {

// The whole file's bytes: every tetrahedron of the model whose four corners have a value, points
// mapped by `grid_to_output`, with the point array "value" (float32) and the cell array "size" (the
// largest extent of the tetrahedron in grid steps). Encoding: appended raw, little endian, 64-bit
// counts.
[[nodiscard]] std::string vtu_file(const Model& model, const Field& field,
                                   const Affine& grid_to_output);

}  // namespace multitetra
